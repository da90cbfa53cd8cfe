"""200 actuators, drawn by the commit's hash: designed from their specification alone, and judged on
56 plants each by a simulator that shares no code with frictool; and that simulator against
`simulate` and `report` on some of the plants.

    python -m tests.accept build/accept.json "synth: 200 drawn actuators"

The trials are kept in build/actuators/HASH.json.trials: the check continues after an interruption.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from frictool.logs.log_reader import read_log
from studies.actuators import documents
from studies.actuators.drawing import Actuator, Plant, draw, draw_plants
from studies.actuators.judge import (
    REQUIREMENTS,
    axis_record,
    plant_figures,
    play,
    step_reference,
)
from studies.actuators.margin import margin
from studies.actuators.native import CACHE, load_exported
from studies.actuators.table import HEADER, row, run_trials, write_table
from studies.actuators.trial import MET, MISSED, summary
from studies.command_line import run, run_checked
from studies.rigs.example_controllers import ROOT
from tests.support.commit_hash import commit_hash

COUNT = 200
LEAST_MET = 0.8  # of all actuators
LEAST_MET_OF_SOLVABLE = 0.97  # of those that the judge's search solves
MOST_FALSE_MET = 0.02  # of the specifications that synth calls met
MOST_SECONDS = 20.0  # processor time of synth without the proof, median
AGREEING = 20  # actuators on which judge and report are compared
COMPARED = (0, 3, 20, 50)  # the nominal plant, two corners and a plant inside
FIGURES = {
    "response_time_95": "response_time_95_s",
    "overshoot": "overshoot_percent",
    "static_error": "static_error",
    "oscillations": "oscillations",
    "drive_peak": "drive_peak",
    "modulus_margin": "modulus_margin",
}  # by their names in a report
RELATIVE = 1e-5  # largest relative difference of a figure


def drawn_actuators() -> dict[str, Any]:
    """Rates over COUNT actuators; a refusal of an actuator that the search solves is a failure."""
    seed = commit_hash()
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


def judge_and_report_agree() -> dict[str, Any]:
    """AGREEING actuators, COMPARED plants each: every count and command, every figure and margin of
    the judge against the log of `simulate` and the verdict of `report`."""
    seed, differences, runs = commit_hash(), [], 0
    for number in range(AGREEING):
        actuator = draw(seed, number)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            documents.write(actuator, folder)
            designed = run(
                "synth", folder / "model.yaml", "--spec", folder / "spec.yaml", "--vertices-only",
                "-o", folder / "controller.yaml",
            )  # fmt: skip
            if designed.code not in (MET, MISSED):
                continue
            run_checked("export", folder / "controller.yaml", "--lang", "c", "-o", folder / "c")
            for index in COMPARED:
                runs += 1
                plant = draw_plants(actuator, seed)[index]
                found = _differences(actuator, plant, folder)
                differences += [f"actuator {number}, plant {index}: {one}" for one in found]
    return {"passed": runs > 0 and not differences, "runs": runs, "differences": differences}


def _differences(actuator: Actuator, plant: Plant, folder: Path) -> list[str]:
    """The signals and figures in which judge and frictool differ."""
    controller, log = folder / "controller.yaml", folder / "run.mcap"
    given = folder / "given.yaml"
    given.write_text(yaml.safe_dump(documents.scenario_of(actuator, plant)))
    run_checked(
        "simulate", folder / "model.yaml", "--controller", controller, "--scenario", given,
        "-o", log,
    )  # fmt: skip
    signals = read_log(log).streams[0].signals
    exported = load_exported(folder / "c")
    reference, _ = step_reference(actuator)
    played = play(axis_record(actuator, plant), reference, exported, plant)
    found = [
        name
        for name, own in (("position", played.seen), ("command", played.commands))
        if not np.array_equal(own, signals[name])
    ]
    report = run(
        "report", log, "--spec", folder / "spec.yaml", "--controller", controller, "--json"
    )
    said = {one["name"]: one["value"] for one in json.loads(report.out)["requirements"]}
    own = dict(zip(REQUIREMENTS, plant_figures(actuator, exported, plant).tolist(), strict=False))
    own["modulus_margin"] = margin(actuator, plant, yaml.safe_load(controller.read_text()))
    for name, key in FIGURES.items():
        value = math.inf if said[name] is None else said[name]
        if not (value == own[key] or abs(value - own[key]) <= RELATIVE * abs(value)):
            found.append(f"{name}: {value} by report, {own[key]} by the judge")
    return found


CHECKS = {
    "synth: 200 drawn actuators": drawn_actuators,
    "synth: judge and report agree": judge_and_report_agree,
}
