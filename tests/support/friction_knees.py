"""Knees of the viscous friction that the method of sines finds on simulated clutches."""

from __future__ import annotations

import numpy as np

from frictool.identify.estimators.sines import sines as method_of_sines
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from studies.rigs.clutch_friction import KNEE
from studies.rigs.curve_logs import nonlinear_clutch
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, ramp, sines
from tests.support.identification_statistics import RATE, experiment

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


def is_knee(knees: list[float]) -> bool:
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
            there = is_knee([regime.above.value for regime in laws.regimes] if laws else [])
            mapped, alone = mapped + (there and number == 0), alone + (there and number == 1)
    return mapped, alone
