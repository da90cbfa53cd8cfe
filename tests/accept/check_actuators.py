"""200 actuators, drawn by the commit's hash: designed from their specification alone, and judged on
56 plants each by a simulator that shares no code with frictool.

    python -m tests.accept build/accept.json "synth: 200 drawn actuators"

The trials are kept in build/actuators/HASH.json.trials: the check continues after an interruption.
"""

from __future__ import annotations

import os
import subprocess
from typing import Any

from studies.actuators.native import CACHE
from studies.actuators.table import HEADER, row, run_trials, write_table
from studies.actuators.trial import summary
from studies.rigs.example_controllers import ROOT

COUNT = 200
LEAST_MET = 0.8  # of all actuators
LEAST_MET_OF_SOLVABLE = 0.97  # of those that the judge's search solves
MOST_FALSE_MET = 0.02  # of the specifications that synth calls met
MOST_SECONDS = 20.0  # processor time of synth without the proof, median


def commit() -> str:
    """The hash of the last commit."""
    done = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def drawn_actuators() -> dict[str, Any]:
    """Rates over COUNT actuators; a refusal of an actuator that the search solves is a failure."""
    seed = commit()
    target = CACHE / f"{seed}.json"
    trials = []
    print(HEADER)
    for trial in run_trials(
        seed, COUNT, target.with_name(f"{target.name}.trials"), os.cpu_count() or 1
    ):
        trials.append(trial)
        print(row(trial), flush=True)
    write_table(seed, trials, target)
    found = summary(trials)
    return {
        "passed": len(trials) == COUNT
        and found["met_rate"] >= LEAST_MET
        and found["met_rate_of_solvable"] >= LEAST_MET_OF_SOLVABLE
        and found["false_met_rate"] <= MOST_FALSE_MET
        and found["median_seconds"] <= MOST_SECONDS,
        "table": str(target.relative_to(ROOT)),
        **found,
    }


CHECKS = {"synth: 200 drawn actuators": drawn_actuators}
