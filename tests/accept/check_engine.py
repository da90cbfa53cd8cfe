"""The engine over a wide range of axes at full count: it always finishes, its pieces make the
whole, and an integrator agrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import DRIVE, GAP, POSITION, VELOCITY, AxisParameters, rest
from frictool.plant.axis_friction_laws import (
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    ViscousRegime,
)
from studies.references.event_integration import event_integration
from studies.rigs.clutch_friction import BACKWARD, FORWARD
from tests.support.axis_reference import follow
from tests.support.axis_runs import CLUTCH, as_motion

AXES, CALLS, REPLAYS, LAWFUL = 60_000, 10, 60, 40


def _axis(rng: np.random.Generator) -> AxisParameters:
    """Inertia, rates and times over many decades; thresholds that coincide, zeros, and what lies
    between."""
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
    return float(
        rng.choice([0.0, threshold, -threshold, 3.0 * rng.normal() / axis.constant, state[DRIVE]])
    )


def always_finishes() -> dict[str, Any]:
    """Every call returns OK within its cap of events, and in parts it gives the same velocity and
    gap."""
    rng, calls, worst = np.random.default_rng(20), 0, 0.0
    for _ in range(AXES):
        axis, duration, state = _axis(rng), 10.0 ** rng.uniform(-5, 0), rest()
        array, parts = axis.as_array(), int(rng.integers(2, 5))
        for _ in range(CALLS):
            command, pieces = _command(rng, axis, state), state.copy()
            before = state.tolist()
            if (
                advance(state, command, array, duration) != OK
                or abs(state[GAP]) > 0.5 * axis.backlash
            ):
                return {
                    "passed": False,
                    "calls": calls,
                    "axis": str(axis),
                    "command": command,
                    "duration": duration,
                    "state": str(before),
                }
            for _ in range(parts):
                advance(pieces, command, array, duration / parts)
            scale = abs(state[VELOCITY]) + 1e-3 * duration / axis.inertia
            worst, calls = max(worst, abs(pieces[VELOCITY] - state[VELOCITY]) / scale), calls + 1
    return {"passed": worst < 1e-7, "calls": calls, "worst_velocity_difference": worst}


def agrees_with_an_integrator() -> dict[str, Any]:
    """Clutch-like axes under random commands against DOP853 with events at a relative tolerance of
    1e-12."""
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
    return {
        "passed": worst < 1e-9 and math.isfinite(worst),
        "samples": REPLAYS * 10,
        "worst_relative_difference": worst,
    }


def _laws(rng: np.random.Generator) -> AxisLaws:
    """Each law or not, over the range of a clutch."""
    forward, backward = (tuple(float(b) for b in curve) for curve in (FORWARD, BACKWARD))
    shape = FrictionPositionShape(0.0, 63.0, (forward, backward), (forward, backward))
    return AxisLaws(
        backward=None
        if rng.random() < 0.3
        else AxisFrictionLevels(
            rng.uniform(0.0, 4e-4), rng.uniform(0.05, 0.12), rng.uniform(0.1, 0.16)
        ),
        regimes=()
        if rng.random() < 0.5
        else (
            ViscousRegime(rng.uniform(20.0, 300.0), rng.uniform(0.0, 1e-3), rng.uniform(0.0, 1e-3)),
        ),
        stribeck_velocity=float(rng.choice([0.0, rng.uniform(1.0, 20.0)])),
        stribeck_exponent=float(rng.choice([1.0, 2.0])),
        fresh=rng.uniform(0.3, 1.0),
        rise_time=float(rng.choice([0.0, 10.0 ** rng.uniform(-4, 0)])),
        shape=None if rng.random() < 0.5 else shape,
        stops=(float(rng.choice([-math.inf, 2.0])), float(rng.choice([math.inf, 12.0]))),
        restitution=float(rng.choice([0.0, 0.5])),
    )


def laws_agree_with_an_integrator() -> dict[str, Any]:
    """Clutch-like axes with laws under random commands against the independent integration of
    tests/support/axis_reference.py."""
    rng, worst = np.random.default_rng(22), 0.0
    for _ in range(LAWFUL):
        axis = CLUTCH._replace(
            lag=float(rng.choice([0.0, rng.uniform(3e-4, 1e-2)])),
            backlash=float(rng.choice([0.0, rng.uniform(0.0, 1.0)])),
            breakaway=rng.uniform(0.1, 0.15),
            laws=_laws(rng),
        )
        array, state = axis.as_array(), rest(rng.uniform(3.0, 11.0))
        for command in rng.uniform(-30.0, 30.0, 8):
            expected = np.array(follow(axis, as_motion(state), float(command), 4e-3)[:4])
            if advance(state, float(command), array, 4e-3) != OK:
                return {"passed": False, "axis": str(axis)}
            scale = np.array([1.0, 30.0 * axis.constant / axis.inertia * 4e-3, 30.0, 1.0])
            difference = float(np.max(np.abs(state[:4] - expected) / scale))
            if difference > 1e-6:
                return {
                    "passed": False,
                    "axis": str(axis),
                    "command": float(command),
                    "difference": difference,
                }
            worst = max(worst, difference)
    return {
        "passed": math.isfinite(worst),
        "samples": LAWFUL * 8,
        "worst_relative_difference": worst,
    }


def laws_always_finish() -> dict[str, Any]:
    """Axes over many decades with laws at their scales: every call returns OK, inside the stops."""
    rng, calls = np.random.default_rng(23), 0
    for _ in range(AXES // 20):
        plain, laws, state = _axis(rng), _laws(rng), rest(rng.uniform(3.0, 11.0))
        axis = plain._replace(
            laws=laws._replace(
                backward=None,
                regimes=tuple(
                    regime._replace(forward=plain.viscous * 2.0, backward=0.0)
                    for regime in laws.regimes
                ),
                stribeck_velocity=laws.stribeck_velocity * 10.0 ** rng.uniform(-6, 0),
            )
        )
        array, duration = axis.as_array(), 10.0 ** rng.uniform(-5, -1)
        for _ in range(CALLS):
            command, before = _command(rng, axis, state), state.tolist()
            status, calls = advance(state, command, array, duration), calls + 1
            if status != OK or not laws.stops[0] <= state[POSITION] <= laws.stops[1]:
                return {
                    "passed": False,
                    "status": status,
                    "axis": str(axis),
                    "command": command,
                    "duration": duration,
                    "state": before,
                }
    return {"passed": True, "calls": calls}


CHECKS = {
    "engine_always_finishes": always_finishes,
    "engine_agrees_with_an_integrator": agrees_with_an_integrator,
    "engine_laws_agree_with_an_integrator": laws_agree_with_an_integrator,
    "engine_laws_always_finish": laws_always_finish,
}
