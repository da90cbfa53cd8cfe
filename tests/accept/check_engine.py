"""The engine over a wide range of axes at full count: it always finishes, its pieces make the whole, and an integrator agrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.engine.axis import advance
from frictool.engine.status import OK
from frictool.plant.axis import DRIVE, GAP, VELOCITY, AxisParameters, rest
from tests.engine.reference import event_integration
from tests.engine.test_axis import CLUTCH

AXES, CALLS, REPLAYS = 60_000, 10, 60


def _axis(rng: np.random.Generator) -> AxisParameters:
    """Inertia, rates and times over many decades; thresholds that coincide, zeros, and what lies between."""
    inertia, coulomb = 10.0 ** rng.uniform(-7, 3), float(rng.choice([0.0, 0.3, 1.0]))
    return AxisParameters(
        inertia=inertia,
        viscous=float(rng.choice([0.0, inertia * 10.0 ** rng.uniform(-9, 3)])),
        coulomb=coulomb,
        breakaway=coulomb * float(rng.choice([1.0, 1.1, 2.0])),
        offset=float(rng.choice([0.0, 0.1])),
        constant=float(rng.choice([1.0, 0.0134])),
        lag=float(rng.choice([0.0, 10.0 ** rng.uniform(-9, 2)])),
        backlash=float(rng.choice([0.0, 1e-6, 1e-3, 1.0])),
        backlash_coulomb=0.5 * coulomb,
        backlash_breakaway=coulomb * float(rng.choice([0.5, 0.55])),
    )


def _command(rng: np.random.Generator, axis: AxisParameters, state: NDArray[np.float64]) -> float:
    """Any, none, exactly the breakaway, or what the drive already is."""
    threshold = axis.breakaway / axis.constant
    return float(rng.choice([0.0, threshold, -threshold, 3.0 * rng.normal() / axis.constant, state[DRIVE]]))


def always_finishes() -> dict[str, Any]:
    """Every call returns OK within its cap of events, and in parts it gives the same velocity and gap."""
    rng, calls, worst = np.random.default_rng(20), 0, 0.0
    for _ in range(AXES):
        axis, duration, state = _axis(rng), 10.0 ** rng.uniform(-5, 0), rest()
        array, parts = axis.as_array(), int(rng.integers(2, 5))
        for _ in range(CALLS):
            command, pieces = _command(rng, axis, state), state.copy()
            before = state.tolist()
            if advance(state, command, array, duration) != OK or abs(state[GAP]) > 0.5 * axis.backlash:
                return {"passed": False, "calls": calls, "axis": str(axis), "command": command, "duration": duration, "state": str(before)}
            for _ in range(parts):
                advance(pieces, command, array, duration / parts)
            scale = abs(state[VELOCITY]) + 1e-3 * duration / axis.inertia
            worst, calls = max(worst, abs(pieces[VELOCITY] - state[VELOCITY]) / scale), calls + 1
    return {"passed": worst < 1e-7, "calls": calls, "worst_velocity_difference": worst}


def agrees_with_an_integrator() -> dict[str, Any]:
    """Clutch-like axes under random commands against DOP853 with events at a relative tolerance of 1e-12."""
    rng, worst = np.random.default_rng(21), 0.0
    for _ in range(REPLAYS):
        axis = CLUTCH._replace(
            viscous=float(rng.choice([0.0, rng.uniform(0.0, 4.4e-3)])),
            lag=float(rng.choice([0.0, rng.uniform(3e-4, 1e-2)])),
            backlash=float(rng.choice([0.0, rng.uniform(0.0, 1.0)])),
            offset=rng.uniform(-0.02, 0.02),
        ).checked()
        array, state = axis.as_array(), rest()
        for command in rng.uniform(-30.0, 30.0, 10):
            expected = np.array(event_integration(axis, state, float(command), 4e-3))
            if advance(state, float(command), array, 4e-3) != OK:
                return {"passed": False, "axis": str(axis)}
            scale = np.array([1.0, 30.0 * axis.constant / axis.inertia * 4e-3, 30.0, 1.0])
            worst = max(worst, float(np.max(np.abs(state[:4] - expected) / scale)))
    return {"passed": worst < 1e-9 and math.isfinite(worst), "samples": REPLAYS * 10, "worst_relative_difference": worst}


CHECKS = {"engine_always_finishes": always_finishes, "engine_agrees_with_an_integrator": agrees_with_an_integrator}
