"""Thesis 5.4 at full count: each design at the 16 vertices and on 1000 random plants of table 5.2,
as make -C configs/clutch counts does, from the bench's logs by the product's commands; and friction
compensation beside the laws that use friction.

    python -m tests.accept build/accept.json "5.4: speed" "5.4: position" ...
"""

from __future__ import annotations

import functools
import tempfile
from dataclasses import asdict
from pathlib import Path
from statistics import mean, median
from typing import Any

import msgspec

from frictool.campaign import ControllerJudge, plants_of_model
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.logs.log_reader import read_log
from studies.clutch.law_comparison import Law, law
from studies.clutch.requirement_counts import PUBLISHED, Counted, Plant, counted, missed
from studies.clutch.rig import CLUTCH, identified, identify_model
from studies.clutch.rig import controller as designed
from studies.command_line import run_checked
from studies.rigs.example_controllers import ROOT

EMPS = ROOT / "configs/emps"
SCENARIOS = ("scenarios/vertices.yaml", "counts/plants_1.yaml", "counts/plants_2.yaml")
LAWS = (
    "linear",
    "cut_off",
    "compensation_measured",
    "compensation_reference",
    "compensation_observer",
    "limiter",
)
USING = ("cut_off", "limiter")


def count(design: str) -> Counted:
    """A design on all of its plants."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        controller, logs = folder / "controller.yaml", []
        spec, chosen = CLUTCH / "spec.yaml", CLUTCH / f"designs/{design}.yaml"
        run_checked(
            "synth",
            identify_model(folder),
            "--spec",
            spec,
            "--design",
            chosen,
            "--no-play",
            "-o",
            controller,
        )
        for scenario in SCENARIOS:
            logs.append(folder / f"{Path(scenario).stem}.mcap")
            run_checked(
                "simulate",
                CLUTCH / "nonlinear.yaml",
                "--controller",
                controller,
                "--scenario",
                CLUTCH / scenario,
                "-o",
                logs[-1],
            )
        return counted(
            load(spec, Spec), load(controller, Controller), (read_log(log) for log in logs)
        )


def _figures(found: Counted) -> dict[str, Any]:
    def spent(group: tuple[Plant, ...]) -> float:
        return mean(mean(plant.energy) for plant in group)

    def worst(key: str) -> float | None:
        values = [getattr(plant, key) for plant in (*found.vertices, *found.plants)]
        return None if None in values else max(values)

    known = [plant.response for plant in found.plants if plant.response is not None]
    return {
        "vertices": sum(plant.all_met for plant in found.vertices),
        "plants": sum(plant.all_met for plant in found.plants),
        "of_plants": len(found.plants),
        "at_rest": sum(plant.met["rest"] for plant in (*found.vertices, *found.plants)),
        "response_median_s": median(known),
        "response_worst_s": worst("response"),
        "overshoot_worst_percent": worst("overshoot"),
        "error_worst_rad": worst("error"),
        "modulus_margin": found.margin,
        "energy": spent((found.nominal,)),
        "energy_vertices": spent(found.vertices),
        "energy_plants": spent(found.plants),
        "energy_published": PUBLISHED.get(found.design),
    }


def counts_of(design: str) -> dict[str, Any]:
    """A design against what is known of it."""
    found = count(design)
    wrong = missed(found)
    return {
        "passed": not wrong and len(found.vertices) == 16 and len(found.plants) == 1000,
        "missed": wrong,
        **_figures(found),
    }


def fast_on_both_models(random: int = 200) -> dict[str, Any]:
    """The fast design on the identified and on the non-linear clutch: every corner within 122 and
    126 ms, and all requirements met at each corner and on all but one of the random plants."""
    steps = load(CLUTCH / "scenarios/steps.yaml", Scenario)
    spec = msgspec.structs.replace(load(CLUTCH / "spec.yaml", Spec), modulus_margin=None)
    made = designed("fast")
    margin = min(vertex.modulus_margin for vertex in made.verified.vertices)
    found: dict[str, Any] = {"modulus_margin": margin}
    passed = margin >= 0.57
    for name, model, slowest in (
        ("identified", identified(), 0.122),
        ("nonlinear", load(CLUTCH / "nonlinear.yaml", Model), 0.126),
    ):
        plants = plants_of_model(model, steps, random)
        corners = len(plants) - random
        verdict = ControllerJudge(model, steps, spec, plants)(made)
        met = (verdict.met == 1).all(axis=1)
        response = verdict.values[:, 0]
        found[name] = {
            "corners_met": int(met[:corners].sum()),
            "random_met": int(met[corners:].sum()),
            "response_worst_s": float(response[:corners].max()),
            "response_median_s": float(median(response)),
        }
        passed &= bool(met[:corners].all()) and int(met[corners:].sum()) >= random - 1
        passed &= float(response[:corners].max()) <= slowest
    return {"passed": passed, **found}


def the_speed_form_spends_least() -> dict[str, Any]:
    """Less than RST and position form, on the nominal plant and on average at the vertices and on
    the random plants; RST only compared."""
    found = {design: _figures(count(design)) for design in PUBLISHED}
    keys = ("energy", "energy_vertices", "energy_plants")
    least = all(
        found["speed"][key] < found[other][key] for other in ("rst", "position") for key in keys
    )
    return {"passed": least, **found}


def laws_of(rig: str) -> dict[str, Any]:
    """Compensation by the model at the measured speed and by an observer cycles; what lets friction
    stop the axis rests without a drive."""
    folder, plant, scenario = {
        "clutch": (CLUTCH, CLUTCH / "nonlinear.yaml", CLUTCH / "scenarios/vertices.yaml"),
        "emps": (EMPS, EMPS / "published.yaml", EMPS / "scenarios/hold.yaml"),
    }[rig]
    with tempfile.TemporaryDirectory() as name:
        own = Path(name)
        model = identify_model(own) if rig == "clutch" else plant
        found = {one: _law(one, own, folder, model, plant, scenario) for one in LAWS}
    cycling = all(
        found[one].cycling > 0 for one in ("compensation_measured", "compensation_observer")
    )
    resting = all(
        found[one].cycling + found[one].untold == 0 and found[one].drive == 0.0 for one in USING
    )
    return {
        "passed": cycling and resting,
        **{one: asdict(figures) for one, figures in found.items()},
    }


def _law(name: str, own: Path, folder: Path, model: Path, plant: Path, scenario: Path) -> Law:
    spec, controller, log = folder / "spec.yaml", own / f"{name}.yaml", own / f"{name}.mcap"
    run_checked(
        "synth",
        model,
        "--spec",
        spec,
        "--design",
        folder / f"laws/{name}.yaml",
        "--no-play",
        "-o",
        controller,
    )
    run_checked("simulate", plant, "--controller", controller, "--scenario", scenario, "-o", log)
    return law(name, load(spec, Spec), load(controller, Controller), read_log(log))


CHECKS = {
    **{
        f"5.4: {design}": functools.partial(counts_of, design)
        for design in ("speed", "position", "fast")
    },
    "5.4: fast on both models": fast_on_both_models,
    "5.4: the speed form spends least": the_speed_form_spends_least,
    **{f"5.1 against 5.2: {rig}": functools.partial(laws_of, rig) for rig in ("clutch", "emps")},
}
