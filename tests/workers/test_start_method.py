"""Platforms without a fork server, such as Windows: commands that share work start their processes
as the platform can."""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing import context
from pathlib import Path

import pytest

from frictool.workers.job_sharing import share
from frictool.workers.process_pool import start_method
from studies.rigs.identification_rigs import CLUTCH, ROOT
from tests.support.worker_jobs import Deadly, series

WITHOUT_FORK = """
import multiprocessing, sys
from multiprocessing import context
for name in ("fork", "forkserver"):
    del context._concrete_contexts[name]
multiprocessing.get_all_start_methods = lambda: ["spawn"]
from frictool.cli.main import main
sys.argv = ["frictool", *sys.argv[1:]]
main()
"""


@pytest.mark.accept
def test_identify_each_runs_without_a_fork_server(tmp_path: Path) -> None:
    logs = [tmp_path / f"{name}.csv" for name in ("first", "second")]
    for log in logs:
        log.write_bytes((ROOT / "sample_logs/sines.csv").read_bytes())
    words = [
        "identify",
        "--each",
        "log",
        *map(str, logs),
        "--bench",
        str(CLUTCH),
        "--cores",
        "2",
        "-o",
        "-",
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    script = [sys.executable, "-c", WITHOUT_FORK]
    result = subprocess.run(
        [*script, *words],
        capture_output=True,
        env=environment,
        check=False,
        cwd=tmp_path,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    header, *rows = result.stdout.splitlines()
    assert len(rows) == 2
    inertias = {row.split(",")[header.split(",").index("inertia")] for row in rows}
    assert len(inertias) == 1
    assert 1.0e-5 < float(inertias.pop()) < 1.7e-5


def test_work_is_shared_and_lost_work_done_again_without_a_fork_server(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = dict(share(series, range(12), cores=1))
    # a private table of multiprocessing, which typeshed does not list
    monkeypatch.delitem(context._concrete_contexts, "forkserver")  # type: ignore[attr-defined]
    monkeypatch.setattr("multiprocessing.get_all_start_methods", lambda: ["spawn"])
    assert start_method() == "spawn"
    assert dict(share(Deadly(tmp_path, (5,), 1), range(12), cores=2, batch=4)) == expected
