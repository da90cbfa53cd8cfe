"""A campaign at full count: 100 000 steps of the clutch on two processes, with kills in the middle,
against one process; worst cases.

python -m tests.accept build/accept.json "campaign: 100 000 trials" ...
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Step
from studies.command_line import run
from studies.rigs.campaign_rig import EVERYTHING, played, write

MANY, FEW = 100_000, 2000
STEP = (Step(Quantity(value=55.0, unit="rad"), 1.1),)
NO_REST = {"rest": None}


def _rows(path: Path) -> list[str]:
    return path.read_text().splitlines()


def _children(process: int) -> list[int]:
    """The processes that descend from one, by Linux's tables."""
    found, waiting = [], [process]
    while waiting:
        parent = waiting.pop()
        for task in Path(f"/proc/{parent}/task").glob("*/children"):
            below = [int(word) for word in task.read_text().split()]
            found += below
            waiting += below
    return found


def _kept(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.is_file() else 0


def _until(lines: int, kept: Path, process: subprocess.Popen[bytes]) -> None:
    while _kept(kept) < lines:
        if process.poll() is not None:
            raise RuntimeError(f"ended with {process.returncode} before {lines} trials")
        time.sleep(0.05)


def many() -> dict[str, Any]:
    """100 000 trials on two processes: one of these killed, then the campaign killed, then
    interrupted, and gone on with; the first 2000 in one process without all that are the same to
    the last digit."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = write(folder, played(None, steps=STEP, drive_noise=0.0), **NO_REST)
        kept, rows, few = folder / "kept.jsonl", folder / "rows.csv", folder / "few.csv"
        words = [
            *map(str, command),
            "-n",
            str(MANY),
            "--cores",
            "2",
            "--keep",
            str(kept),
            "--table",
            str(rows),
        ]
        killed = 0
        for lines, how in ((MANY // 10, "worker"), (MANY // 4, "kill"), (MANY // 2, "interrupt")):
            with subprocess.Popen(
                [sys.executable, "-m", "frictool", *words],
                stderr=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
            ) as process:
                _until(lines, kept, process)
                workers = _children(process.pid)
                if how == "worker":
                    os.kill(max(workers), signal.SIGKILL)
                    killed += 1
                    _until(lines + MANY // 20, kept, process)
                process.send_signal(signal.SIGINT if how == "interrupt" else signal.SIGKILL)
                process.communicate()
                killed += process.returncode == -signal.SIGKILL
            time.sleep(3.0)  # workers end with the campaign
            left = [
                one
                for one in workers
                if Path(f"/proc/{one}").exists()
                and "Z" not in Path(f"/proc/{one}/stat").read_text().split()[2]
            ]
            if left:
                raise RuntimeError(f"{len(left)} processes are left after {how}")
        begun = time.perf_counter()
        ended = run(*words)
        seconds = time.perf_counter() - begun
        run(*command, "-n", str(FEW), "--cores", "1", "--table", few)
        all_rows, first = _rows(rows), _rows(few)
        numbers = [int(row.partition(",")[0]) for row in all_rows[1:]]
        return {
            "passed": ended.code in (0, 1)
            and numbers == list(range(MANY))
            and all_rows[: FEW + 1] == first,
            "trials": len(numbers),
            "kills": killed,
            "seconds_of_the_rest": seconds,
            "not_simulated": sum(row.split(",")[2] != "" for row in all_rows[1:]),
        }


def worst() -> dict[str, Any]:
    """With everything varied, the search is worse than the worst of 3000 draws, and each case is
    played again to the same value."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = write(folder, played(EVERYTHING, steps=STEP), **NO_REST)
        output = folder / "found.yaml"
        run(
            *command,
            "-n",
            "3000",
            "--cores",
            "1",
            "--worst",
            folder / "worst",
            "--evaluations",
            "600",
            "-o",
            output,
        )
        found = yaml.safe_load(output.read_text())
        drawn = {metric["name"]: metric for metric in found["metrics"]}
        same, gains = [], {}
        for case in found["worst"]:
            log, scenario = folder / "run.mcap", folder / "worst" / case["scenario"]
            run(
                "simulate",
                folder / "model.yaml",
                "--controller",
                folder / "controller.yaml",
                "--scenario",
                scenario,
                "-o",
                log,
            )
            judged = run(
                "report",
                log,
                "--spec",
                folder / "spec.yaml",
                "--controller",
                folder / "controller.yaml",
                "--json",
            )
            again = next(
                r["value"]
                for r in yaml.safe_load(judged.stdout)["requirements"]
                if r["name"] == case["requirement"]
            )
            same.append(again == case["value"])
            metric = drawn[case["requirement"]]
            value, before = (
                np.inf if one is None else one for one in (case["value"], metric["worst"]["value"])
            )
            gains[case["requirement"]] = (
                before - value if metric["relation"] == ">=" else value - before
            )
        finite = {key: float(gain) for key, gain in gains.items() if np.isfinite(gain)}
        passed = (
            {*gains} == {metric["name"] for metric in found["metrics"] if metric["relation"]}
            and all(same)
            and all(gain >= 0.0 for gain in finite.values())
            and finite.get("overshoot", 1.0) > 0.0
        )
        return {"passed": passed, "cases": len(same), "replayed": sum(same), "worse_by": finite}


CHECKS = {"campaign: 100 000 trials": many, "campaign: worst cases": worst}
