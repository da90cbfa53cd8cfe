"""Work shared among the workers of a Dask cluster: the bits of one process, whatever dies; and one
line where it cannot be."""

from __future__ import annotations

import signal
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from frictool.errors import ClusterError
from frictool.runtime import notifications
from frictool.workers import dask_cluster, dask_connection, file_transfer
from frictool.workers.file_transfer import share_files
from frictool.workers.installation_agreement import Installation, differences, installation
from frictool.workers.job_sharing import share
from tests.support.local_cluster import Loopback, end
from tests.support.shared_sums import spectrum
from tests.support.worker_jobs import Deadly, compiles, content, greedy, instead, negative

pytest.importorskip("distributed")
JOBS = 60


@pytest.fixture(scope="module")
def loopback(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loopback]:
    made = Loopback(tmp_path_factory.mktemp("cluster"), workers=2)
    yield made
    made.close()


def test_a_worker_killed_in_the_middle_loses_nothing_and_changes_no_bit(loopback: Loopback) -> None:
    alone = dict(share(spectrum, range(JOBS), cores=1))
    found: list[tuple[int, np.ndarray]] = []
    for done in share(spectrum, range(JOBS), cluster=loopback.address, batch=3):
        found.append(done)
        if len(found) == 12:
            end(loopback.workers[0])
    assert sorted(index for index, _ in found) == list(range(JOBS))
    assert all(result.tobytes() == alone[index].tobytes() for index, result in found)


@pytest.mark.skipif(sys.platform != "linux", reason="a path that is another file in each process")
def test_a_file_that_the_workers_do_not_see_is_sent(
    loopback: Loopback, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    own = Path("/proc/self/cwd")
    (tmp_path / "here.csv").write_bytes(b"a,b\n")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_bytes(b"x: 1\n")
    (tmp_path / "log.db3").write_bytes(b"\0\1")
    (tmp_path / "large.csv").write_bytes(b"1," * 600)
    monkeypatch.setattr(file_transfer, "LARGEST_SENT", 1000)
    jobs = [
        ((tmp_path / "here.csv",), "seen"),
        ((own / "here.csv", own / "log.db3"), "sent"),
        ((own / "large.csv",), "large"),
    ]
    jobs.append(((tmp_path / "large.csv",), "large and seen"))
    found = dict(share_files(content, jobs, instead, cluster=loopback.address))
    assert found[0] == ("seen", [("here.csv", b"a,b\n")])
    assert found[1] == ("sent", [("here.csv", b"a,b\n"), ("log.db3", b"\0\1")])
    ((reason, _),) = found[2][1]
    assert "is missing on the worker" in reason
    assert found[3] == ("large and seen", [("large.csv", b"1," * 600)])


def test_workers_that_are_not_alike_are_refused_by_name(
    loopback: Loopback, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = installation()
    other = Installation((("frictool", "9.9"), *here.versions[1:]), here.processor)
    monkeypatch.setattr(dask_cluster, "installation", lambda: other)
    with pytest.raises(
        ClusterError, match=r"workers differ from this machine: .*frictool .*sources .*here 9\.9"
    ):
        list(share(negative, range(3), cluster=loopback.address))
    monkeypatch.setattr(
        dask_cluster, "_check", lambda client, address: None
    )  # one that joins later is found out by its task
    with pytest.raises(ClusterError, match=r"differs from this machine: frictool .*, here 9\.9"):
        list(share(negative, range(3), cluster=loopback.address))


@pytest.mark.skipif(sys.platform == "win32", reason="processes are stopped by a signal")
def test_a_worker_that_hangs_at_the_start_is_waited_for_and_told(
    loopback: Loopback, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []

    def wake(text: str) -> None:
        told.append(text)
        loopback.workers[-1].send_signal(signal.SIGCONT)

    monkeypatch.setattr(dask_cluster, "SLOW_S", 0.2)
    loopback.workers[-1].send_signal(signal.SIGSTOP)
    with notifications.receiving(remark=wake):
        assert dict(share(negative, range(5), cluster=loopback.address)) == {
            number: -number for number in range(5)
        }
    assert "a worker does not answer; frictool waits" in told[0]


def test_a_machine_that_compiles_is_told_once(loopback: Loopback) -> None:
    remarks: list[str] = []
    with notifications.receiving(remark=remarks.append):
        assert len(list(share(compiles, range(20), cluster=loopback.address))) == 20
    assert sum("compiling, once per installation" in text for text in remarks) == 1
    assert socket.gethostname() in remarks[0]


def test_what_a_job_raises_comes_back_and_then_the_scheduler_goes(loopback: Loopback) -> None:
    with pytest.raises(Exception, match="no samples") as raised:
        list(share(negative, range(20), cluster=loopback.address))
    assert str(raised.value) == "run.csv:3: has no samples"
    found: list[int] = []

    def until_it_is_gone() -> None:
        for index, _ in share(spectrum, range(10_000), cluster=loopback.address):
            found.append(index)
            if len(found) == 5:
                end(loopback.scheduler)

    with pytest.raises(
        ClusterError, match="the connection to the scheduler is lost; finished jobs are kept"
    ):
        until_it_is_gone()
    assert len(found) >= 5


@pytest.mark.accept
def test_workers_whose_memory_is_short_are_told_in_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, seconds in (("LONG_S", 0.5), ("NO_WORKER_S", 1.0), ("LOOK_S", 0.2)):
        monkeypatch.setattr(dask_cluster, name, seconds)
    made = Loopback(tmp_path, workers=0, failures=0)
    try:  # without a supervisor, one that has paused never ends, and begins nothing more
        made.workers.append(made.add("--memory-limit", "150MB"))
        with pytest.raises(
            ClusterError,
            match=r"no worker whose memory allows another task \(`dask worker --memory-limit`\)",
        ):
            list(share(greedy, range(9), cluster=made.address))
        made.workers += [made.add(), made.add()]
        end(made.workers.pop(0))
        for name in ("HOPELESS", "AHEAD"):
            monkeypatch.setattr(dask_cluster, name, 1)
        monkeypatch.setattr(dask_cluster, "NO_WORKER_S", 60.0)
        with pytest.raises(ClusterError, match="every worker that received a task died"):
            list(share(Deadly(tmp_path, tuple(range(9)), 9), range(9), cluster=made.address))
    finally:
        made.close()


def test_no_cluster_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_connection, "CONNECT_S", 0.3)
    for address, word in (
        ("127.0.0.1:8786", "allowed: tcp://HOST:PORT"),
        ("tcp://127.0.0.1", "allowed: tcp://HOST:PORT"),
        ("tcp://127.0.0.1:1", "no Dask scheduler answers"),
        ("tcp://127.0.0.1:99999", "no Dask scheduler answers"),
    ):
        with pytest.raises(ClusterError, match=word):
            list(share(negative, range(3), cluster=address))
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'frictool\[cluster\]'"):
        list(share(negative, range(3), cluster="tcp://127.0.0.1:8786"))


def test_differences_name_both_sides() -> None:
    here, there = (
        Installation((("numpy", "2.4"), ("scipy", "1.1")), ""),
        Installation((("numpy", "2.3"), ("scipy", "1.1")), ""),
    )
    assert differences(here, there) == "numpy 2.3, here 2.4"
    assert differences(here, here) == ""
    foreign = Exception(
        "ModuleNotFoundError(\"No module named 'frictool.workers'\")"
    )  # as Dask brings it
    assert dask_cluster._unlike(here, foreign) == "no frictool, or another version"
    assert dask_cluster._unlike(here, RuntimeError("disk")) == "RuntimeError: disk"
    assert {"frictool", "numpy", "numba", "python"} <= dict(installation().versions).keys()
