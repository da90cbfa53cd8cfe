"""Coulomb friction: dissipates in slip, holds up to the breakaway and not beyond."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.coulomb_viscous import breakaway_direction, slip_force

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
@given(effort=EFFORTS, forward=SIZES, backward=SIZES)
def test_breakaway_follows_the_effort_beyond_the_threshold_only(
    effort: float, forward: float, backward: float
) -> None:
    direction = breakaway_direction(effort, forward, backward)
    assert direction == (0.0 if -backward <= effort <= forward else math.copysign(1.0, effort))
