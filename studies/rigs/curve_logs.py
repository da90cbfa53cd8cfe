"""Logs for curves over speed: sines of the mass of table 4.1, tests of the non-linear clutch."""

from __future__ import annotations

import numpy as np

from frictool.adapters.axis_model import axis_of
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from studies.rigs.engine_pointer import advance_pointer
from studies.rigs.identification_rigs import (
    MASS,
    MASS_NOISE,
    MASS_PERIOD,
    MASS_POLE,
    ROOT,
    position_loop,
    record,
)
from studies.rigs.sample_logs import PERIOD, TRUTH, play_reference

SPEEDS = (2.0, 4.0, 6.0, 8.0, 10.0)  # m/s
PERIODS = 3  # of 1 s at each speed
SETTLE = 1000  # samples


def mass_sines(seed: int, step: float = MASS.encoder_step) -> list[MotionRecord]:
    """Return sines of 1 Hz under the position loop of table 4.1, one log for each of SPEEDS."""
    generator = np.random.default_rng([seed, 5])
    gains = np.array(
        [
            3.0 * MASS_POLE**2 * MASS.inertia,
            MASS_POLE**3 * MASS.inertia,
            3.0 * MASS_POLE * MASS.inertia - MASS.viscous,
        ]
    )
    logs = []
    for speed in SPEEDS:
        time = np.arange(SETTLE + PERIODS * 1000, dtype=np.float64) * MASS_PERIOD
        reference = (
            -speed
            / (2.0 * np.pi)
            * np.cos(2.0 * np.pi * time + generator.uniform(0.0, 2.0 * np.pi))
        )
        x, u = np.empty(time.size), np.empty(time.size)
        state = np.asarray(rest(reference[0] + step * generator.random()))
        plant, advance = MASS.as_array(), advance_pointer()
        status = position_loop(state, reference, gains, plant, step, MASS_PERIOD, x, u, advance)
        assert status == 0
        u += MASS_NOISE * generator.standard_normal(u.size)
        kept = slice(SETTLE, None)
        logs.append(
            make_record(f"{speed:g} m/s", time[kept], x[kept], u[kept], resolution=step, lag=0.0)
        )
    return logs


def nonlinear_clutch() -> AxisParameters:
    """Return the clutch of configs/clutch/nonlinear.yaml (tables 4.5 to 4.8, 5.2)."""
    return axis_of(load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model))


RUN_SPEEDS = (3.0, 5.0, 8.0, 12.0, 18.0, 25.0, 40.0, 60.0, 80.0, 110.0)  # rad/s
RUN_SECONDS = 0.8
STRIBECK_VELOCITY = 12.0  # rad/s
FINE = 2.0 * np.pi / 4096.0


def stribeck_axis() -> AxisParameters:
    """Return the sample logs' clutch with a Stribeck curve (2.34), without backlash.

    The encoder has 4096 counts per turn.
    """
    truth = TRUTH._replace(breakaway=0.12, backlash=0.0, encoder_step=FINE)
    return truth._replace(laws=truth.laws._replace(stribeck_velocity=STRIBECK_VELOCITY))


def constant_speeds(seed: int, truth: AxisParameters) -> MotionRecord:
    """Return runs to and fro at RUN_SPEEDS under the bench's servo."""
    generator = np.random.default_rng([seed, 11])
    speed = np.concatenate(
        [
            np.full(round(RUN_SECONDS / PERIOD), side * value)
            for value in RUN_SPEEDS
            for side in (1.0, -1.0)
        ]
    )
    position = 30.0 - 0.5 * RUN_SECONDS * RUN_SPEEDS[0] + np.cumsum(speed) * PERIOD
    log = play_reference(
        position, speed, np.sign(speed) * truth.coulomb / truth.constant, generator, truth
    )
    return record(log, truth, "constant speeds")
