"""Mechanisms of thesis 2.1-2.2 at full count: the exhaustive clutch against its reduction under
every law of 5.4, its reductions over the slideway's friction, the elastic rebound of 4.4.4, and
closed forms at many parameters.

    python -m tests.accept build/accept.json "clutch, part by part: speed" ...
"""

from __future__ import annotations

import functools
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.writing import to_yaml
from frictool.logs.log_reader import read_log
from studies.clutch.mechanism_comparison import compared, missed
from studies.clutch.rig import CLUTCH, identify_model
from studies.clutch.torque_ramps import missed as not_shown
from studies.clutch.torque_ramps import ramps, yielding
from studies.command_line import run_checked
from tests.support.belt_reference import BELT as BELT
from tests.support.belt_reference import Belt
from tests.support.mechanism_motion import play
from tests.support.screw_reference import SCREW as SCREW
from tests.support.screw_reference import Screw

LAWS = ("speed", "fast", "position", "rst")
PLANTS = 200
SCREWS, BELTS = 200, 200


def _controller(design: str, folder: Path) -> Path:
    target = folder / f"{design}.yaml"
    if not target.exists():
        chosen = CLUTCH / f"designs/{design}.yaml"
        run_checked(
            "synth",
            identify_model(folder),
            "--spec",
            CLUTCH / "spec.yaml",
            "--design",
            chosen,
            "--no-play",
            "-o",
            target,
        )
    return target


def clutch_of(design: str) -> dict[str, Any]:
    """The rotor within the backlash, the response within 5 %, 5.4.1 met on the exhaustive clutch
    wherever it is on the reduced one.

    And on how many of the mechanisms drawn from the intervals of each. RST meets 5.4.1 on neither:
    it is only compared.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        controller, scenario, model = (
            _controller(design, folder),
            folder / "scenario.yaml",
            folder / "reduced.yaml",
        )
        text = (CLUTCH / "scenarios/mechanism.yaml").read_text()
        scenario.write_text(text.replace("plants: 20", f"plants: {PLANTS}"))
        run_checked("reduce", CLUTCH / "mechanism.yaml", "-o", model)
        for plant, log in ((CLUTCH / "mechanism.yaml", "exhaustive"), (model, "reduced")):
            run_checked(
                "simulate",
                plant,
                "--controller",
                controller,
                "--scenario",
                scenario,
                "-o",
                folder / f"{log}.mcap",
            )
        logs = (read_log(folder / f"{log}.mcap") for log in ("exhaustive", "reduced"))
        found = compared(design, load(CLUTCH / "spec.yaml", Spec), *logs)
    return {
        "passed": not missed(found),
        "missed": missed(found),
        "rotor_apart_rad": found.apart,
        "response_exhaustive_s": found.exhaustive[0].response,
        "response_reduced_s": found.reduced[0].response,
        "plants": len(found.exhaustive),
        "exhaustive_meets": sum(plant.all_met for plant in found.exhaustive),
        "reduced_meets": sum(plant.all_met for plant in found.reduced),
    }


def screws() -> dict[str, Any]:
    """The engine against scipy on the screw's own equations, at random: mu on both sides of
    tan(alpha), both forms of friction."""
    random, worst, held = np.random.default_rng(216), 0.0, 0
    for index in range(SCREWS):
        steep, mu = float(random.uniform(0.03, 0.8)), float(random.uniform(0.01, 0.5))
        form = ("angle", "thesis")[index % 2]
        torques = random.uniform(-1.0, 2.0, 5)
        found = play(
            SCREW.format(angle=math.atan(steep), mu=mu, form=form).replace(
                "100, unit: N}", "0, unit: N}"
            ),
            [[u] for u in torques for _ in range(50)],
        )
        by_hand = Screw(2e-5, 1.0, 6e-3, steep, mu, 20e3, thesis=form == "thesis")
        breaks = tuple(0.05 * k for k in range(1, 5))
        theta, _ = by_hand.trajectory(
            lambda t, u=torques: float(u[min(int(t / 0.05 + 1e-9), 4)]), 0.0, found.time, breaks
        )
        worst = max(
            worst,
            float(np.abs(found.position("screw") - theta).max() / max(np.abs(theta).max(), 1e-3)),
        )
        held += bool(found.speed("screw")[-1] == 0.0)
    return {
        "passed": worst < 1e-6 and 0 < held < SCREWS,
        "worst_relative": worst,
        "screws": SCREWS,
        "at_rest_in_the_end": held,
    }


def belts() -> dict[str, Any]:
    """The engine's answer to a step of torque against the belt's own, drawn at random over four
    decades of inertia and stiffness."""
    random, worst = np.random.default_rng(215), 0.0
    for _ in range(BELTS):
        a, b = 10.0 ** random.uniform(-5, -1, 2)
        k = 10.0 ** random.uniform(0, 4)
        fast = math.sqrt(k * (a + b) / (a * b))
        c = random.uniform(0.0, 0.9) * 2.0 * k / fast
        by_hand = Belt(float(a), float(b), float(k), float(c))
        text = BELT.format(
            a=by_hand.inertia_a,
            b=by_hand.inertia_b,
            k=by_hand.stiffness,
            c=by_hand.damping,
            radius_a=1.0,
            radius_b=1.0,
        )
        found = play(text, [[1.0]] * 100, period=0.2 / fast)
        expected = by_hand.step(found.time)
        worst = max(worst, float(np.abs(found.position("b") - expected).max() / expected.max()))
    return {"passed": worst < 1e-6, "worst_relative": worst, "belts": BELTS}


def rebound() -> dict[str, Any]:
    """4.4.4: under the PID the ramps of the torque lie around 0 with rigid flanks, off centre with
    compliant flanks."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        controller = folder / "linear.yaml"
        run_checked(
            "synth",
            identify_model(folder),
            "--spec",
            CLUTCH / "spec.yaml",
            "--design",
            CLUTCH / "laws/linear.yaml",
            "--no-play",
            "-o",
            controller,
        )
        (folder / "yielding.yaml").write_text(
            to_yaml(yielding(load(CLUTCH / "mechanism.yaml", Mechanism)))
        )
        found = []
        for plant in (CLUTCH / "mechanism.yaml", folder / "yielding.yaml"):
            log = folder / f"{plant.stem}.mcap"
            run_checked(
                "simulate",
                plant,
                "--controller",
                controller,
                "--scenario",
                CLUTCH / "scenarios/rebound.yaml",
                "-o",
                log,
            )
            found.append(ramps(read_log(log)))
    return {
        "passed": not not_shown(*found),
        "missed": not_shown(*found),
        "rigid_worst": max(one.asymmetry for one in found[0]),
        "yielding": [round(one.asymmetry, 3) for one in found[1]],
    }


CHECKS = {
    **{f"clutch, part by part: {design}": functools.partial(clutch_of, design) for design in LAWS},
    "4.4.4: elastic rebound": rebound,
    "screw and nut against scipy": screws,
    "belt against its closed form": belts,
}
