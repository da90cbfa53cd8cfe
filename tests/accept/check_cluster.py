"""Commands on a Dask cluster on the loopback: the bytes of one process, while workers are killed;
what a cluster cannot do is one line."""

from __future__ import annotations

import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from frictool.errors import ClusterError, WorkerLost
from frictool.workers.job_sharing import share
from studies.command_line import CommandResult, run
from studies.rigs.campaign_rig import EVERYTHING, played, write
from studies.rigs.clutch_fleet import Unit
from studies.rigs.fleet_logs import cut, log_of, model_file, save
from studies.rigs.identification_rigs import CLUTCH
from tests.support.local_cluster import Loopback, end
from tests.support.shared_sums import spectrum
from tests.support.worker_jobs import Deadly, series

JOBS, BATCH = 3000, 5
KILLS = 6
UNITS, LOGS, SECONDS = 4, 3, 40.0
TRIALS = 2000


def killed() -> dict[str, Any]:
    """KILLS workers of two are killed one after another, each replaced; every bit of JOBS results
    is that of one process."""
    alone = dict(share(spectrum, range(JOBS), cores=1))
    with tempfile.TemporaryDirectory() as folder:
        loopback = Loopback(Path(folder), workers=2)
        try:
            found: list[tuple[int, Any]] = []
            for done in share(spectrum, range(JOBS), cluster=loopback.address, batch=BATCH):
                found.append(done)
                if len(found) % (JOBS // (KILLS + 1)) == 0 and len(found) < JOBS - BATCH:
                    loopback.workers.append(loopback.add())
                    end(loopback.workers[len(loopback.workers) - 3])
        finally:
            loopback.close()
    once = sorted(index for index, _ in found) == list(range(JOBS))
    same = all(np.array_equal(result, alone[index]) for index, result in found)
    return {
        "passed": once and same and len(loopback.workers) == KILLS + 2,
        "killed": len(loopback.workers) - 2,
        "each_once": once,
        "bits": same,
    }


def guilty() -> dict[str, Any]:
    """A job that ends every worker is named, or replaced; what was beside it is done."""
    with tempfile.TemporaryDirectory() as folder:
        marks = Path(folder, "marks")
        marks.mkdir()
        loopback = Loopback(Path(folder), workers=2, failures=1)
        refill = _Refill(loopback)
        try:
            with refill:
                found = dict(
                    share(
                        Deadly(marks, (7,), 99),
                        range(60),
                        cluster=loopback.address,
                        batch=4,
                        instead=lambda job, why: [0.0],
                    )
                )
                try:
                    list(
                        share(Deadly(marks, (7,), 99), range(60), cluster=loopback.address, batch=4)
                    )
                    named = None
                except WorkerLost as lost:
                    named = lost.job
        finally:
            loopback.close()
    others = all(found[job] == series(job) for job in range(60) if job != 7)
    return {
        "passed": len(found) == 60 and found[7] == [0.0] and others and named == 7,
        "deaths": len(refill.ended),
        "named": named,
    }


class _Refill:
    """Starts another worker for each that has ended, as a supervisor does."""

    def __init__(self, loopback: Loopback) -> None:
        self._loopback, self._over, self.ended = loopback, threading.Event(), set[int]()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._over.wait(0.1):
            for place, worker in enumerate(self._loopback.workers):
                if worker.poll() is not None and place not in self.ended:
                    self.ended.add(place)
                    self._loopback.workers.append(self._loopback.add())

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join()


def commands() -> dict[str, Any]:
    """`observe run` and `identify --each` over a fleet with a damaged log: the same files by one
    process and by a cluster."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        model = model_file(root)
        for unit in range(UNITS):
            for log in range(LOGS):
                wear = Unit(wear=1.0 + 0.1 * log)
                save(
                    log_of(wear, 10 * unit + log, SECONDS),
                    root / "fleet" / f"U{unit}" / f"2026-0{log + 1}-03.mcap",
                )
        cut(save(log_of(Unit(), 99, SECONDS), root / "fleet" / "U9" / "2026-01-09.mcap"))
        loopback = Loopback(root, workers=2)
        try:
            shared = ("--cluster", loopback.address)
            codes = [
                _both(model, root, name, options).code
                for name, options in (("one", ("--cores", "1")), ("cluster", shared))
            ]
            identified = [
                run(
                    "identify",
                    "--each",
                    "log",
                    root / "fleet",
                    "--bench",
                    CLUTCH,
                    *options,
                    "-o",
                    root / name / "models",
                ).code
                for name, options in (("one", ("--cores", "1")), ("cluster", shared))
            ]
        finally:
            loopback.close()
        names = [
            sorted(path.relative_to(root / one) for path in (root / one).rglob("*.*"))
            for one in ("one", "cluster")
        ]
        same = names[0] == names[1] and all(
            (root / "one" / name).read_bytes() == (root / "cluster" / name).read_bytes()
            for name in names[0]
        )
    passed = (
        same
        and codes == [3, 3]
        and identified[0] == identified[1] == 3
        and len(names[0]) > UNITS * LOGS
    )
    return {
        "passed": passed,
        "files": len(names[0]),
        "same": same,
        "exit_codes": [*codes, *identified],
    }


def _both(model: Path, root: Path, name: str, options: tuple[str, ...]) -> CommandResult:
    (root / name).mkdir()
    return run(
        "observe",
        "run",
        model,
        root / "fleet",
        "--date",
        r"\d{4}-\d\d-\d\d",
        *options,
        "-o",
        root / name / "fleet.csv",
    )


def abandoned() -> dict[str, Any]:
    """Whoever loses every worker, or the scheduler, is told so in time."""
    from frictool.workers import dask_cluster

    dask_cluster.NO_WORKER_S = 3.0
    told: dict[str, float] = {}
    for whom in ("workers", "scheduler"):
        with tempfile.TemporaryDirectory() as folder:
            loopback = Loopback(Path(folder), workers=1)
            lost = 0.0
            try:
                for index, _ in share(spectrum, range(100_000), cluster=loopback.address):
                    if index == 20:
                        end(loopback.workers[0] if whom == "workers" else loopback.scheduler)
                        lost = time.monotonic()
            except ClusterError as error:
                if ("no worker" if whom == "workers" else "scheduler is lost") in str(error):
                    told[whom] = time.monotonic() - lost
            finally:
                loopback.close()
    return {
        "passed": told.get("workers", 99.0) < 15.0 and told.get("scheduler", 99.0) < 15.0,
        "told_after_s": told,
    }


def campaign() -> dict[str, Any]:
    """A campaign on a cluster: the scheduler is killed in the middle, then a worker of another; the
    file is that of one process."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        asked = [*write(root, played(EVERYTHING), rest=None), "-n", str(TRIALS), "--seed", "5"]
        kept = ("--keep", root / "kept.jsonl")
        codes = [run(*asked, "--cores", "1", "-o", root / "one.yaml").code]
        for number, whom in enumerate(("scheduler", "worker")):
            (root / whom).mkdir()
            loopback = Loopback(root / whom, workers=2)
            killer = threading.Thread(
                target=_end_after,
                args=(root / "kept.jsonl", TRIALS // 4 * (number + 1), loopback, whom),
            )
            killer.start()
            try:
                result = run(
                    *asked, "--cluster", loopback.address, *kept, "-o", root / "cluster.yaml"
                )
            finally:
                killer.join()
                loopback.close()
            codes.append(result.code)
            if whom == "scheduler":
                gone = (
                    "the connection to the scheduler is lost" in result.stderr
                    and not (root / "cluster.yaml").exists()
                )
        same = (root / "one.yaml").read_bytes() == (root / "cluster.yaml").read_bytes()
    return {
        "passed": gone and same and codes[1] == 3 and codes[0] == codes[2],
        "gone": gone,
        "same": same,
        "exit_codes": codes,
    }


def _end_after(kept: Path, lines: int, loopback: Loopback, whom: str) -> None:
    """Ends the scheduler or a worker when so many trials are kept."""
    until = time.monotonic() + 120.0
    while time.monotonic() < until and not (
        kept.is_file() and kept.read_bytes().count(b"\n") > lines
    ):
        time.sleep(0.01)
    end(loopback.scheduler if whom == "scheduler" else loopback.workers[0])


CHECKS = {
    "cluster.campaign": campaign,
    "cluster.killed": killed,
    "cluster.guilty": guilty,
    "cluster.commands": commands,
    "cluster.abandoned": abandoned,
}
