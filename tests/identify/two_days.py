"""A carriage whose viscous friction differs by direction, on two days on which its dry friction and
its offset differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from frictool.engine.bench_position_loop import PositionServo, follow_reference
from frictool.engine.effort_replay import replay_parameters
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.typing import Vector

PERIOD, SAMPLES, STEP, NOISE = 1e-3, 20_000, 5e-8, 1.0  # s, m, N
CONSTANT = 35.15065  # N/V
INERTIA = 95.0  # kg
STROKE, MOVES = 2.1, 0.87  # s, and the share of it in which the reference moves
LENGTHS = (0.125, 0.1625, 0.2)  # m

DAYS = {  # viscous forward, backward [N s/m]; Coulomb forward, backward [N]; offset [N]
    "monday": (165.0, 240.0, 20.0, 20.6, -3.2),
    "tuesday": (170.0, 245.0, 22.0, 21.0, -2.5),
}


def _reference() -> Vector:
    """Strokes to and fro along minimum-jerk profiles, three lengths in turn (n,), m."""
    time = np.arange(SAMPLES) * PERIOD
    stroke = (time // STROKE).astype(int)
    s = np.minimum((time % STROKE) / (STROKE * MOVES), 1.0)
    profile = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    return np.array(LENGTHS)[stroke // 2 % 3] * np.where(stroke % 2 == 0, profile, 1.0 - profile)


def day(name: str, seed: int = 1) -> MotionRecord:
    """The record of a day: the carriage under its servo, its effort with noise."""
    forward, backward, coulomb, other, offset = DAYS[name]
    levels = AxisFrictionLevels(backward, other, other)
    axis = AxisParameters(
        INERTIA, forward, coulomb, coulomb, offset, laws=AxisLaws(backward=levels)
    )
    x, v, u = np.empty(SAMPLES), np.empty(SAMPLES), np.empty(SAMPLES)
    servo = np.array(
        PositionServo(CONSTANT * 160.0 * 243.0, derivative=CONSTANT * 243.0, limit=350.0)
    )
    assert (
        follow_reference(
            replay_parameters(axis), np.empty(0), rest(), servo, _reference(), 0.0, PERIOD, x, v, u
        )
        == 0
    )
    noisy = u + NOISE * np.random.default_rng(seed).standard_normal(SAMPLES)
    return make_record(
        name, np.arange(SAMPLES) * PERIOD, np.floor(x / STEP) * STEP, noisy, STEP, 0.0
    )


def written(folder: Path, name: str) -> Path:
    """The same as a CSV with the columns of the bench of EMPS."""
    record = day(name)
    path = folder / f"{name}.csv"
    table = np.column_stack(
        (record.time, record.position, record.position, record.effort / CONSTANT)
    )
    np.savetxt(path, table, delimiter=",", header="t,qm,qg,vir", comments="", fmt="%.12g")
    return path
