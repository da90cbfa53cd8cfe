"""A stranger's machine: two builds of a commit, a wheel with nothing else around it, processes that
begin at once on an empty cache."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Any

from frictool.runtime.kernel_folders import PREFIX
from release.__main__ import ROOT, main

CLUTCH, LOGS = ROOT / "configs/clutch", ROOT / "sample_logs"
AT_ONCE = 4
KILLED_AFTER_S = (2.0, 5.0, 8.0)  # from the start of a process that begins on an empty cache
CHAIN = (
    "ingest {logs}/sines.csv --bench {clutch}/bench.yaml -o sines.mcap",
    "ingest {logs}/ramp.csv --bench {clutch}/bench.yaml -o ramp.mcap",
    "identify sines.mcap ramp.mcap --bench {clutch}/bench.yaml -o model.yaml",
    "synth model.yaml --spec {clutch}/spec.yaml --design {clutch}/designs/speed.yaml "
    "--vertices-only -o controller.yaml",
    "simulate model.yaml --controller controller.yaml --scenario {clutch}/scenarios/steps.yaml -o "
    "run.mcap",
    "report run.mcap --spec {clutch}/spec.yaml --controller controller.yaml -o report.html",
    "export controller.yaml --lang c -o c",
)


def two_builds_are_one() -> dict[str, Any]:
    """The last commit built twice, in surroundings that differ, and complete."""
    with tempfile.TemporaryDirectory() as place, contextlib.redirect_stdout(io.StringIO()):
        main(Path(place))
        return {
            "passed": True,
            **dict(
                reversed(line.split("  "))
                for line in Path(place, "SHA256SUMS").read_text().splitlines()
            ),
        }


def the_wheel_runs_by_itself() -> dict[str, Any]:
    """In an environment with its dependencies only, from another folder: version, doctor, and the
    chain from bench logs to C."""
    with tempfile.TemporaryDirectory() as place:
        with contextlib.redirect_stdout(io.StringIO()):
            main(Path(place, "dist"))
        (wheel,) = Path(place, "dist").glob("*.whl")
        venv.create(Path(place, "env"), with_pip=True)
        programs, folder = Path(place, "env/bin"), Path(place, "elsewhere")
        folder.mkdir()
        _run(
            [
                programs / "python",
                "-m",
                "pip",
                "install",
                "-q",
                "-c",
                ROOT / "constraints.txt",
                wheel,
            ],
            folder,
        )
        version = _run([programs / "frictool", "--version"], folder)
        start = time.perf_counter()
        for line in CHAIN:
            _run([programs / "frictool", *line.format(logs=LOGS, clutch=CLUTCH).split()], folder)
        took = time.perf_counter() - start
        doctor = json.loads(_run([programs / "frictool", "doctor", "--json"], folder))
        kernels = next(one for one in doctor["checks"] if one["check"] == "kernels")
        inside = str(Path(place, "env").resolve()) in str(Path(kernels["folder"]).resolve())
        return {
            "passed": doctor["is_in_order"] and inside,
            "version": version.strip(),
            "chain_s": round(took, 1),
            "kernels": kernels["functions"],
        }


def many_begin_at_once() -> dict[str, Any]:
    """On an empty cache: every process finds the same, and the next one compiles nothing."""
    with tempfile.TemporaryDirectory() as place:
        processes = [_identifying(Path(place), f"model-{number}.yaml") for number in range(AT_ONCE)]
        codes = [process.wait() for process in processes]
        models = {Path(place, f"model-{number}.yaml").read_bytes() for number in range(AT_ONCE)}
        before = _kept(Path(place))
        again = _identifying(Path(place), "again.yaml").wait()
        same = {Path(place, "again.yaml").read_bytes()} == models
        unchanged = _kept(Path(place)) == before
        passed = (
            codes == [0] * AT_ONCE
            and again == 0
            and len(models) == 1
            and same
            and unchanged
            and bool(before)
        )
        return {
            "passed": passed,
            "processes": AT_ONCE,
            "models": len(models),
            "files": len(before),
            "compiled_again": not unchanged,
        }


def one_is_killed() -> dict[str, Any]:
    """While it compiles and keeps: whoever comes next finds what is found on an untouched cache."""
    with tempfile.TemporaryDirectory() as place, tempfile.TemporaryDirectory() as other:
        _identifying(Path(other), "model.yaml").wait()
        expected = Path(other, "model.yaml").read_bytes()
        left = []
        for after in KILLED_AFTER_S:
            process = _identifying(Path(place), "killed.yaml")
            time.sleep(after)
            process.kill()
            process.wait()
            left.append(len(_kept(Path(place))))
        code = _identifying(Path(place), "model.yaml").wait()
        return {
            "passed": code == 0 and Path(place, "model.yaml").read_bytes() == expected,
            "files_left": left,
        }


def _identifying(place: Path, name: str) -> subprocess.Popen[bytes]:
    """A process that keeps its kernels in `place`, where nothing was compiled."""
    words = (
        f"identify {LOGS}/sines.csv {LOGS}/ramp.csv --bench {CLUTCH}/bench.yaml -o {place / name}"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(place / "kernels")}
    return subprocess.Popen(
        [sys.executable, "-m", "frictool", *words.split()],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def _kept(place: Path) -> dict[str, int]:
    """Return the kept kernels with the time of their last write."""
    found = (
        path
        for folder in (place / "kernels").glob(f"{PREFIX}*")
        for path in folder.rglob("*.nb[ic]")
    )
    return {path.name: path.stat().st_mtime_ns for path in found}


def _run(command: list[Any], folder: Path) -> str:
    """Return the output of a program.

    Raises RuntimeError with its last line if its exit code is not 0.
    """
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "NUMBA_CACHE_DIR")
    }
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(
            f"{Path(command[0]).name} {command[1]}: exit {done.returncode}: "
            f"{(done.stderr or done.stdout).strip()[-300:]}"
        )
    return done.stdout


CHECKS = {
    "two builds of a commit are the same bytes": two_builds_are_one,
    "the wheel runs in an environment of its own": the_wheel_runs_by_itself,
    "several processes begin at once on an empty cache": many_begin_at_once,
    "a process is killed while it compiles": one_is_killed,
}
