"""A PI position loop around a mass with stiction: it hunts for ever, and no longer does where the
drive is cut in a band (5.2.2)."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import POSITION, VELOCITY, AxisParameters, rest

MASS = AxisParameters(inertia=1.0, viscous=0.4, coulomb=1.0, breakaway=1.5)
PERIOD, SECONDS = 1e-3, 420.0
PROPORTIONAL, INTEGRAL, DERIVATIVE = 4.0, 2.0, 4.0


def hunt(axis: AxisParameters, band: float) -> np.ndarray:
    """Positions of a step of 1 m at 1 kHz; within `band` of the target and below 0.01 m/s drive and
    integral are zero."""
    array, state, integral = axis.as_array(), rest(), 0.0
    positions = np.empty(round(SECONDS / PERIOD))
    for k in range(positions.size):
        error, velocity = 1.0 - state[POSITION], state[VELOCITY]
        integral += INTEGRAL * error * PERIOD
        drive = PROPORTIONAL * error + integral - DERIVATIVE * velocity
        if abs(error) < band and abs(velocity) < 0.01:
            drive, integral = 0.0, 0.0
        assert advance(state, drive, array, PERIOD) == OK
        positions[k] = state[POSITION]
    return positions


def starts(positions: np.ndarray) -> np.ndarray:
    """Samples at which the axis leaves a rest."""
    moving = np.diff(positions) != 0.0
    return np.flatnonzero(moving[1:] & ~moving[:-1]) + 1


def test_integral_action_hunts_where_breakaway_exceeds_coulomb_friction() -> None:
    positions = hunt(MASS, band=0.0)
    rests = positions[starts(positions)] - 1.0
    assert rests.size > 12
    assert abs(rests[-1]) > 0.05
    np.testing.assert_allclose(
        rests[-5:-1], -rests[-4:], rtol=1e-3
    )  # from side to side, neither growing nor dying
    assert np.diff(starts(positions))[-1] == pytest.approx(np.diff(starts(positions))[-2], rel=1e-3)


def test_the_band_ends_the_cycle() -> None:
    positions = hunt(MASS, band=0.3)
    assert np.flatnonzero(np.diff(positions))[-1] * PERIOD < 30.0
    assert abs(1.0 - positions[-1]) < 0.3
