"""One axis: physics that no friction may break, closed forms by hand, and two slow references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import NOT_FINITE, OK
from frictool.plant.axis import (
    DRIVE,
    GAP,
    LOAD_POSITION,
    LOOSE,
    MODE,
    POSITION,
    SLIPPING,
    STUCK,
    VELOCITY,
    AxisParameters,
    rest,
)
from studies.references.event_integration import event_integration, time_stepping
from tests.support.axis_runs import BARE, CLUTCH, COMMANDS, run

AXES = st.builds(
    lambda viscous, breakaway, lag, backlash, offset: CLUTCH._replace(
        viscous=viscous, breakaway=breakaway, lag=lag, backlash=backlash, offset=offset
    ),
    viscous=st.sampled_from([0.0, 3.8e-4, 4.4e-3]),  # 4.4e-3: J/viscous equals the lag of 3 ms
    breakaway=st.sampled_from([0.099, 0.109, 0.2]),
    lag=st.sampled_from([0.0, 3e-4, 3e-3]),
    backlash=st.sampled_from([0.0, 0.02, 3.0]),
    offset=st.sampled_from([0.0, 0.02, -0.01]),
)


@pytest.mark.parametrize("effort", [1.4999999, 1.5, -1.5, 0.0])
def test_holds_exactly_up_to_the_breakaway(effort: float) -> None:
    state = run(BARE, [effort] * 1000)
    assert (state[POSITION], state[VELOCITY], state[MODE]) == (0.0, 0.0, STUCK)


def test_moves_just_beyond_the_breakaway() -> None:
    state = run(BARE, [math.nextafter(1.5, 2.0)])
    assert state[MODE] == SLIPPING
    assert state[VELOCITY] == pytest.approx(
        0.5e-3, rel=1e-12
    )  # breakaway - coulomb = 0.5 N accelerates 1 kg


@pytest.mark.parametrize("velocity", [2.0, -0.3])
def test_coasts_down_on_a_parabola(velocity: float) -> None:
    state = rest()
    state[VELOCITY] = velocity
    run(BARE, [0.0] * 3, period=1.0, state=state)
    assert state[POSITION] == pytest.approx(
        math.copysign(velocity**2 / 2.0, velocity), rel=1e-14
    )  # v0^2 J/(2 Fc)
    assert state[VELOCITY] == 0.0


def test_coasts_down_with_viscous_friction() -> None:
    p, v0 = BARE._replace(viscous=0.7), 2.0
    state = rest()
    state[VELOCITY] = v0
    run(p, [0.0], period=5.0, state=state)
    assert state[POSITION] == pytest.approx(v0 / 0.7 - math.log1p(0.7 * v0) / 0.49, rel=1e-13)


def test_breaks_away_when_the_lagging_drive_reaches_the_threshold() -> None:
    p = BARE._replace(lag=0.2)
    moment = 0.2 * math.log(2.0 / (2.0 - 1.5))
    before = run(p, [2.0], period=math.nextafter(moment, 0.0) * (1 - 1e-14))
    assert before[VELOCITY] == 0.0
    after = run(p, [2.0], period=moment + 0.1)
    slipped = 0.5 * 0.1 + 0.5 * (
        0.1 - 0.2 * (1 - math.exp(-0.5))
    )  # int (2 - 0.5 e^{-t/lag} - 1) dt
    assert after[VELOCITY] == pytest.approx(slipped, rel=1e-12)


def test_breaks_away_without_a_jump_where_breakaway_is_coulomb_friction() -> None:
    """At the threshold nothing accelerates but rounding; a state in which stop and breakaway once
    chased each other."""
    p = CLUTCH._replace(
        inertia=6.981067816286203e-05,
        viscous=0.0,
        coulomb=1.0,
        breakaway=1.0,
        offset=0.1,
        lag=0.00013695001383866654,
    )
    p = p._replace(
        drive_limit=math.inf, backlash=0.001, backlash_coulomb=0.5, backlash_breakaway=0.55
    )
    state = np.array(
        [-0.0008695420573285649, 0.0, 74.55186769034435, 0.0005, -0.001369542057328565, 0.0, 0.0]
    )
    command, duration = 82.377879530717, 0.0009452002877781537
    x, v, drive, gap = event_integration(p, state, command, duration)
    run(p, [command], duration, state)
    np.testing.assert_allclose(state[:4], [x, v, drive, gap], rtol=1e-7)


def test_lets_go_where_the_effort_falls_from_the_threshold() -> None:
    """The drive stands on the breakaway, an ulp beyond it in effort, and reverses: another stop
    that chased its breakaway."""
    p = CLUTCH._replace(
        inertia=8.239388702323114e-06, viscous=0.0013223462328762084, coulomb=0.3, breakaway=0.3
    )
    p = p._replace(
        lag=4.586875357877132e-05, backlash=1.0, backlash_coulomb=0.15, backlash_breakaway=0.165
    )
    state = np.array(
        [
            -1.3406974085415995,
            -8.630428065841487e-42,
            -22.388059701492537,
            -0.5,
            -0.8406974085415995,
            -1.0,
            0.0,
        ]
    )
    command, duration = 23.266554086095336, 0.6272006173861266
    run(p, [command], duration, state)
    assert (state[MODE], state[GAP]) == (SLIPPING, 0.5)
    settled = (p.constant * command - p.coulomb) / p.viscous
    assert state[VELOCITY] == pytest.approx(settled, rel=1e-6)


def test_crosses_the_backlash_then_takes_the_load_along() -> None:
    p = BARE._replace(backlash=0.5, backlash_coulomb=0.2, backlash_breakaway=0.3)
    state = run(p, [1.2], period=math.sqrt(0.5) * (1 - 1e-12))  # 0.25 m at 1 m/s^2
    assert state[MODE] == LOOSE
    assert state[LOAD_POSITION] == 0.0
    run(p, [1.2], period=0.1 + math.sqrt(0.5) * 1e-12, state=state)
    assert (state[MODE], state[GAP]) == (SLIPPING, 0.25)
    assert state[LOAD_POSITION] == pytest.approx(math.sqrt(0.5) * 0.1 + 0.5 * 0.2 * 0.01, rel=1e-10)


def test_rest_at_the_edge_holds_outwards_and_lets_go_inwards() -> None:
    p = BARE._replace(backlash=0.5, backlash_coulomb=0.2, backlash_breakaway=0.3)
    state = rest()
    state[GAP] = 0.25
    assert run(p, [1.4], state=state.copy())[VELOCITY] == 0.0
    inwards = run(p, [-0.4], state=state.copy())
    assert inwards[MODE] == -LOOSE
    assert inwards[VELOCITY] == pytest.approx(-0.2e-3, rel=1e-12)


def test_reverses_through_zero_within_one_call() -> None:
    state = rest()
    state[VELOCITY] = 1.0
    run(
        BARE, [-3.0], period=1.0, state=state
    )  # stops after 1/4 s and 1/8 m, then -2 m/s^2 for 3/4 s
    assert state[VELOCITY] == pytest.approx(-1.5, rel=1e-14)
    assert state[POSITION] == pytest.approx(0.125 - 0.5625, rel=1e-14)


def test_drive_is_limited() -> None:
    state = run(CLUTCH, [1e9] * 50)
    assert state[DRIVE] == pytest.approx(50.0, rel=1e-6)
    assert state[DRIVE] <= 50.0


@pytest.mark.parametrize(
    ("command", "duration"), [(math.nan, 1e-3), (math.inf, 1e-3), (1.0, math.nan), (1.0, -1.0)]
)
def test_what_is_not_finite_is_refused_and_nothing_moves(command: float, duration: float) -> None:
    state = rest(0.5, 1.0)
    assert advance(state, command, CLUTCH.as_array(), duration) == NOT_FINITE
    np.testing.assert_array_equal(state, rest(0.5, 1.0))


@given(p=AXES, commands=COMMANDS, parts=st.integers(2, 7))
def test_a_sample_in_parts_is_the_same_sample(
    p: AxisParameters, commands: list[float], parts: int
) -> None:
    whole, state, array = rest(), rest(), p.as_array()
    for command in commands:
        assert advance(whole, command, array, 5e-3) == OK
        for _ in range(parts):
            assert advance(state, command, array, 5e-3 / parts) == OK
    np.testing.assert_allclose(state[:5], whole[:5], rtol=1e-8, atol=1e-10)


@given(p=AXES, commands=COMMANDS)
def test_friction_never_creates_energy(p: AxisParameters, commands: list[float]) -> None:
    """Work of the effort minus kinetic energy is at least the Coulomb loss over the way, the work
    at its most: in each of 200 parts of a sample the effort is between its ends, wherever in the
    part the axis stops."""
    array, state, parts = p.as_array(), rest(), 200
    for command in commands:
        kinetic, work, gross, way = 0.5 * p.inertia * state[VELOCITY] ** 2, 0.0, 0.0, 0.0
        for _ in range(parts):
            x, effort = (
                state[POSITION],
                p.constant * (state[DRIVE] if p.lag > 0 else command) - p.offset,
            )
            assert advance(state, command, array, 2e-3 / parts) == OK
            moved = state[POSITION] - x
            part = max(effort * moved, (p.constant * state[DRIVE] - p.offset) * moved)
            work, gross, way = work + part, gross + abs(part), way + abs(moved)
        lost = work - (0.5 * p.inertia * state[VELOCITY] ** 2 - kinetic)
        rounding = 1e-12 * p.backlash_coulomb * way + 1e-15
        assert lost >= p.backlash_coulomb * way - 1e-3 * gross - rounding
        assert p.backlash > 0 or lost >= p.coulomb * way - 1e-3 * gross - 1e-15


@given(p=AXES, commands=COMMANDS)
def test_the_gap_stays_within_the_backlash_and_joins_motor_and_load(
    p: AxisParameters, commands: list[float]
) -> None:
    array, state = p.as_array(), rest(0.3)
    for command in commands:
        assert advance(state, command, array, 4e-3) == OK
        assert abs(state[GAP]) <= 0.5 * p.backlash
        assert state[POSITION] - state[LOAD_POSITION] == pytest.approx(state[GAP], abs=1e-12)


@given(p=AXES, commands=COMMANDS)
def test_is_odd(p: AxisParameters, commands: list[float]) -> None:
    forward = run(p, commands, 3e-3)
    backward = run(p._replace(offset=-p.offset), [-command for command in commands], 3e-3)
    np.testing.assert_array_equal(forward, -backward)


@given(p=AXES, commands=st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=4))
def test_agrees_with_time_stepping(p: AxisParameters, commands: list[float]) -> None:
    """Without events, modes or closed forms; breakaway equal to Coulomb friction, where the motion
    depends continuously on the input."""
    p = p._replace(breakaway=p.coulomb, backlash_breakaway=p.backlash_coulomb)
    state = rest()
    for command in commands:
        x, v, gap = time_stepping(p, state, command, 4e-3, 2e-6)
        run(p, [command], 4e-3, state)
        scale = 50.0 * p.constant / p.inertia * 4e-3  # the speed that the limit gives in one call
        assert state[VELOCITY] == pytest.approx(v, abs=2e-3 * scale)
        assert state[POSITION] == pytest.approx(x, abs=2e-3 * scale * 4e-3)
        assert state[GAP] == pytest.approx(gap, abs=2e-3 * scale * 4e-3 + 1e-12)


@pytest.mark.parametrize("lag", [0.0, 3e-3, 1.32e-5 / 3.8e-4])
@pytest.mark.parametrize("viscous", [0.0, 3.8e-4])
@pytest.mark.parametrize("seed", [1, 2])
def test_agrees_with_an_integrator_with_events(lag: float, viscous: float, seed: int) -> None:
    p = CLUTCH._replace(lag=lag, viscous=viscous, backlash=0.3, offset=0.01)
    rng = np.random.default_rng(seed)
    state = rest()
    for command in rng.uniform(-30.0, 30.0, 12):
        x, v, drive, gap = event_integration(p, state, command, 4e-3)
        run(p, [command], 4e-3, state)
        np.testing.assert_allclose(state[:4], [x, v, drive, gap], rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("ulps", [0, 1, 2, 3])
def test_an_effort_on_the_breakaway_to_rounding_moves_nothing_without_a_lag(ulps: int) -> None:
    """Friction 0.13 N m, 2.6 A at 0.05 N m/A: what rounding leaves above it is no acceleration, and
    no division by the lag's rate."""
    level = 0.13
    for _ in range(ulps):
        level = math.nextafter(level, 0.0)
    axis = AxisParameters(
        inertia=2.2e-4, viscous=0.0, coulomb=level, breakaway=level, constant=0.05
    )
    state = run(axis, [2.59, 2.6, 2.6])
    assert state[MODE] == STUCK
    assert state[VELOCITY] == 0.0
    assert run(axis, [2.7], state=state)[VELOCITY] > 0.0
