"""Work shared among processes: the same bytes whoever does it; a process that is ended loses
nothing; none outlives what shares it."""

from __future__ import annotations

import contextlib
import itertools
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from frictool.errors import LogError, WorkerLost
from frictool.runtime import notifications
from frictool.workers.job_sharing import available_cores, share
from tests.support.worker_jobs import Deadly, compiles, negative, series, untravelled

JOBS = 40
SCRIPT = """
import sys
from frictool.workers.job_sharing import share
from tests.support.worker_jobs import slow_series
if __name__ == "__main__":
    for done in share(slow_series, range(100_000), cores=2):
        print("done", flush=True)
"""


@pytest.fixture(scope="module")
def alone() -> dict[int, list[float]]:
    """Return the result of one process."""
    return dict(share(series, range(JOBS), cores=1))


def each_once(results: Iterator[tuple[int, list[float]]]) -> dict[int, list[float]]:
    found = list(results)
    assert sorted(index for index, _ in found) == list(range(JOBS))
    return dict(found)


def test_processes_change_no_bit_and_what_dies_is_done_again(
    alone: dict[int, list[float]], tmp_path: Path
) -> None:
    remarks: list[str] = []
    with notifications.receiving(remark=remarks.append):
        shared = share(Deadly(tmp_path, (5, 6, 39), 2), range(JOBS), cores=2, batch=7)
        assert each_once(shared) == alone
    assert len(list(tmp_path.iterdir())) == 6  # each of the three ended two processes
    assert len(remarks) == 6
    assert all("SIGKILL" in text for text in remarks)
    assert not multiprocessing.active_children()


def test_a_job_that_ends_every_process_is_named_or_replaced(
    alone: dict[int, list[float]], tmp_path: Path
) -> None:
    with pytest.raises(WorkerLost, match=r"job 5: each of 3 worker processes .*SIGKILL") as lost:
        list(share(Deadly(tmp_path, (5,), 99), range(JOBS), cores=2, batch=4))
    assert lost.value.job == 5
    assert not multiprocessing.active_children()
    given = Deadly(tmp_path, (5,), 99)
    found = each_once(
        share(given, range(JOBS), cores=2, batch=4, instead=lambda job, reason: [float(job)])
    )
    assert found.pop(5) == [5.0]
    assert found == {index: one for index, one in alone.items() if index != 5}


def test_an_error_comes_back_as_it_was_and_ends_the_others() -> None:
    for cores in (1, 2):
        with pytest.raises(LogError, match="no samples") as raised:
            list(share(negative, range(20), cores=cores))
        assert str(raised.value) == "run.csv:3: has no samples"
        assert (raised.value.path, raised.value.line) == ("run.csv", 3)
    assert any(
        "negative" in note for note in raised.value.__notes__
    )  # where it was raised, in the other process
    assert not multiprocessing.active_children()


def test_jobs_are_asked_for_as_they_are_needed_and_leaving_ends_the_processes() -> None:
    taken: list[int] = []

    def endless() -> Iterator[int]:
        for number in itertools.count(100):
            taken.append(number)
            yield number

    results = share(negative, endless(), cores=2, batch=5)
    assert {-result for _, result in itertools.islice(results, 12)} <= set(range(100, 125))
    assert len(taken) < 50
    results.close()
    assert not multiprocessing.active_children()


def test_a_wait_for_the_compiler_is_told_here() -> None:
    told: list[str] = []
    with notifications.receiving(compiling=lambda: told.append("compiling")):
        assert dict(share(compiles, range(6), cores=2)) == {number: number for number in range(6)}
    assert len(told) == 6


def test_what_cannot_travel_is_told() -> None:
    with pytest.raises((AttributeError, TypeError), match=r"pickle|local object"):
        list(share(untravelled, range(4), cores=2))
    with pytest.raises((AttributeError, TypeError), match=r"pickle|local object"):
        list(share(lambda job: job, range(4), cores=2))
    with pytest.raises(ValueError, match="at least 1"):
        list(share(negative, range(4), cores=0))
    assert list(share(negative, [], cores=2)) == []
    assert available_cores() >= 1


def in_group(group: int) -> set[int]:
    """The processes of a group that are not over."""
    found = set()
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError):
                state, _, own = (folder / "stat").read_text().rpartition(")")[2].split()[:3]
                if int(own) == group and state != "Z":
                    found.add(int(folder.name))
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="asks /proc")
@pytest.mark.parametrize(
    ("ended_by", "whom"), [(signal.SIGINT, "group"), (signal.SIGKILL, "itself")]
)
def test_no_process_outlives_the_one_that_shares(
    ended_by: signal.Signals, whom: str, tmp_path: Path
) -> None:
    script = tmp_path / "sharing.py"
    script.write_text(SCRIPT)
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    child = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        start_new_session=True,
    )
    assert child.stdout is not None
    assert child.stderr is not None
    for _ in range(3):
        assert child.stdout.readline() == b"done\n"
    assert len(in_group(child.pid)) >= 3  # itself and two that work
    (os.killpg if whom == "group" else os.kill)(child.pid, ended_by)
    child.stdout.close()
    until = time.monotonic() + 20.0
    while in_group(child.pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert not in_group(child.pid)
    told = child.stderr.read().decode()
    child.stderr.close()
    child.wait()
    assert told.count("Traceback") == (1 if ended_by == signal.SIGINT else 0), (
        told
    )  # its own, none of a worker
