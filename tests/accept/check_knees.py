"""Knees of friction over speed: none on a plain clutch, whatever its inertia is within the bench's
range, and that of figure 4.10 is found.

Plain are the axes of `check_identify`. The knee is that of the non-linear clutch
(configs/clutch/nonlinear.yaml), its inertia drawn from the bench's range: from sines and ramps
together, since its friction varies with position (`friction_map`), and from sines alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from frictool.identify.estimators.sines import sines as method_of_sines
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from studies.rigs.curve_logs import nonlinear_clutch
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, ramp, sines
from tests.accept.check_identify import RATE, experiment
from tests.identify.test_friction_map import KNEE

CLUTCHES, KNEES = 200, 100
FALSE, FOUND = 0.02, 0.95
NEAR = 0.1  # of the knee


def false_knees(clutches: int, encoder_step: float = TRUTH.encoder_step) -> int:
    """On how many plain clutches sines, with the bench's inertia, see a knee."""
    found = 0
    for seed in range(clutches):
        truth, bench = experiment(seed, encoder_step)
        found += (
            method_of_sines(
                [record(sines(seed, truth), truth)], bench, IdentificationSettings(RATE)
            ).details["knees"]
            > 0
        )
    return found


def _is_there(knees: list[float]) -> bool:
    return len(knees) == 1 and abs(knees[0] - KNEE) < NEAR * KNEE


def true_knees(clutches: int) -> tuple[int, int]:
    """On how many non-linear clutches the knee, and no other, is found: with ramps, and by sines
    alone."""
    bench, mapped, alone = clutch(), 0, 0
    for seed in range(clutches):
        inertia = float(
            np.random.default_rng([seed, 77]).uniform(*bench.mechanics.inertia.interval)
        )
        truth = nonlinear_clutch()._replace(inertia=inertia)
        log = record(sines(seed, truth), truth)
        for number, ramps in enumerate(([record(ramp(seed, truth), truth, "ramp")], [])):
            laws = identify_records([log], ramps, bench, "sines", IdentificationSettings(RATE)).laws
            there = _is_there([regime.above.value for regime in laws.regimes] if laws else [])
            mapped, alone = mapped + (there and number == 0), alone + (there and number == 1)
    return mapped, alone


def knees() -> dict[str, Any]:
    """At most 2 % of false knees, and 95 % of the true ones."""
    false, (mapped, alone) = false_knees(CLUTCHES), true_knees(KNEES)
    passed = false <= FALSE * CLUTCHES and mapped >= FOUND * KNEES
    return {
        "passed": passed,
        "plain": CLUTCHES,
        "false_knees": false,
        "with_knee": KNEES,
        "found": mapped,
        "found_by_sines_alone": alone,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"identify: knees, false and true": knees}
