"""Coulomb friction: dissipates in slip, holds up to the breakaway and not beyond."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.coulomb_viscous import breakaway_direction, slip_force, slip_force_slope

SIZES = st.floats(0.0, 1e6)
EFFORTS = st.floats(-1e6, 1e6)


@settings(derandomize=True, deadline=None)
@given(speed=SIZES, direction=st.sampled_from([1.0, -1.0]), coulomb=SIZES, viscous=SIZES)
def test_slip_force_opposes_the_motion(
    speed: float, direction: float, coulomb: float, viscous: float
) -> None:
    force = slip_force(direction * speed, direction, coulomb, viscous)
    assert force * direction >= coulomb
    assert math.isclose(force, direction * (coulomb + viscous * speed), rel_tol=1e-15)


@settings(derandomize=True, deadline=None)
@given(velocity=st.floats(0.1, 1e3), coulomb=SIZES, viscous=st.floats(0.1, 1e3))
def test_slope_is_the_derivative(velocity: float, coulomb: float, viscous: float) -> None:
    step = 1e-3 * velocity
    upper, lower = (slip_force(velocity + s, 1.0, 0.0, viscous) for s in (step, -step))
    assert math.isclose(
        (upper - lower) / (2 * step),
        slip_force_slope(velocity, 1.0, coulomb, viscous),
        rel_tol=1e-9,
    )


@settings(derandomize=True, deadline=None)
@given(effort=EFFORTS, forward=SIZES, backward=SIZES)
def test_breakaway_follows_the_effort_beyond_the_threshold_only(
    effort: float, forward: float, backward: float
) -> None:
    direction = breakaway_direction(effort, forward, backward)
    assert direction == (0.0 if -backward <= effort <= forward else math.copysign(1.0, effort))
