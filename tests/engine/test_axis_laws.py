"""The axis with laws: closed forms by hand, an independent integration of each law, and what no
friction may break."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.drive_lag import NEVER, outgrowing_time
from frictool.engine.status_codes import OK
from frictool.plant.axis import (
    DRIVE,
    GAP,
    LOAD_POSITION,
    MODE,
    POSITION,
    RESTED,
    STUCK,
    VELOCITY,
    AxisParameters,
    rest,
)
from frictool.plant.axis_friction_laws import (
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    ViscousRegime,
)
from studies.rigs.clutch_friction import BACKWARD, FORWARD
from tests.support.axis_reference import coulomb, follow
from tests.support.axis_runs import BARE, CLUTCH, COMMANDS, as_motion, run

FAST = settings(max_examples=settings.default.max_examples // 2)
MAP = FrictionPositionShape(0.0, 63.0, (FORWARD, BACKWARD), (FORWARD, BACKWARD))
OWN = FrictionPositionShape(0.0, 63.0, ((1.0,), (0.9, 1e-3)), ((1.2, 2e-3), (1.0, 5e-3, -4e-5)))
KNEE = (ViscousRegime(260.0, 3.81e-4, 2e-4),)
TIGHT = CLUTCH._replace(backlash=0.0)

LAWS = {
    "stops": AxisLaws(stops=(-2.0, 3.0)),
    "rebounds": AxisLaws(stops=(-2.0, 3.0), restitution=0.6),
    "directions": AxisLaws(backward=AxisFrictionLevels(1e-4, 0.12, 0.15)),
    "knee": AxisLaws(regimes=KNEE),
    "two knees": AxisLaws(
        regimes=(ViscousRegime(40.0, 1e-4, 2e-3), ViscousRegime(150.0, 1e-3, 0.0)),
        backward=AxisFrictionLevels(5e-4, 0.08, 0.1),
    ),
    "position": AxisLaws(shape=MAP, backward=AxisFrictionLevels(0.0, 0.11, 0.121)),
    "own polynomials": AxisLaws(shape=OWN),
    "narrow map": AxisLaws(shape=FrictionPositionShape(4.0, 6.0, ((1.0, 0.3), (2.0, -0.2)), ((1.0,
    0.3), (2.0, -0.2)))),
    "stribeck": AxisLaws(stribeck_velocity=5.0),
    "stribeck, odd exponent": AxisLaws(stribeck_velocity=8.0, stribeck_exponent=1.3),
    "dwell": AxisLaws(fresh=0.5, rise_time=2e-3),
    "all": AxisLaws(
        backward=AxisFrictionLevels(1e-4, 0.11, 0.14), regimes=KNEE,
        stribeck_velocity=6.0, fresh=0.8, rise_time=5e-3, shape=OWN, stops=(1.0, 9.0),
        restitution=0.3,
    ),
}  # fmt: skip
CASES = pytest.mark.parametrize("name", LAWS)
RICH = st.builds(
    lambda name, lag, backlash, breakaway: CLUTCH._replace(
        laws=LAWS[name], lag=lag, backlash=backlash, breakaway=breakaway
    ),
    name=st.sampled_from(sorted(LAWS)),
    lag=st.sampled_from([0.0, 3e-4, 3e-3]),
    backlash=st.sampled_from([0.0, 0.3]),
    breakaway=st.sampled_from([0.115, 0.16]),
)


@CASES
@pytest.mark.parametrize("backlash", [0.0, 0.3])
def test_agrees_with_an_integrator_with_events(name: str, backlash: float) -> None:
    p = CLUTCH._replace(laws=LAWS[name], backlash=backlash, breakaway=0.13, offset=0.004)
    rng, state = (
        np.random.default_rng(3),
        rest(5.0 if name != "stops" and name != "rebounds" else 0.0),
    )
    for command in [*rng.uniform(-40.0, 40.0, 2), 11.0, 7.5, -12.0]:
        expected = follow(p, as_motion(state), float(command), 6e-3)
        run(p, [float(command)], 6e-3, state)
        np.testing.assert_allclose(state[:4], expected[:4], rtol=1e-6, atol=1e-7)


def test_an_end_stop_holds_what_pushes_and_lets_go_what_pulls() -> None:
    p = BARE._replace(laws=AxisLaws(stops=(-1.0, 0.5)))
    state = run(p, [3.0], period=2.0)  # 2 m/s^2 over 0.5 m: there at sqrt(1/2) s
    assert (state[POSITION], state[VELOCITY], state[MODE]) == (0.5, 0.0, STUCK)
    run(p, [1e6], period=1.0, state=state)
    assert (state[POSITION], state[VELOCITY]) == (0.5, 0.0)
    run(p, [-1.4], period=1.0, state=state)  # inwards the breakaway holds it
    assert state[POSITION] == 0.5
    run(p, [-2.0], period=1.0, state=state)
    assert state[POSITION] == pytest.approx(0.0, abs=1e-12)


def test_a_rebound_has_its_share_of_the_speed() -> None:
    p = BARE._replace(laws=AxisLaws(stops=(-1.0, 0.5), restitution=0.5))
    state = rest()
    state[VELOCITY] = 3.0
    hit = math.sqrt(9.0 - 2.0 * 0.5)  # coasting against 1 N over 0.5 m
    run(p, [0.0], period=10.0, state=state)
    assert state[POSITION] == pytest.approx(0.5 - 0.5 * (0.5 * hit) ** 2, rel=1e-12)


def test_rebounds_under_effort_end_at_the_stop() -> None:
    state = run(
        BARE._replace(laws=AxisLaws(stops=(-1.0, 0.5), restitution=0.9)), [3.0], period=100.0
    )
    assert (state[POSITION], state[VELOCITY]) == (0.5, 0.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_steady_speed_beyond_the_knee(direction: float) -> None:
    """u = F_c + s1 knee + s2 (w - knee)."""
    p = BARE._replace(viscous=0.1, laws=AxisLaws(regimes=(ViscousRegime(2.0, 0.5, 0.8),)))
    slope = 0.5 if direction > 0 else 0.8
    state = run(p, [direction * (1.0 + 0.2 + slope * 3.0)], period=500.0)
    assert state[VELOCITY] == pytest.approx(direction * 5.0, rel=1e-12)
    run(p, [direction * (1.0 + 0.1)], period=500.0, state=state)
    assert state[VELOCITY] == pytest.approx(direction * 1.0, rel=1e-12)


def test_an_axis_that_settles_on_its_knee() -> None:
    state = run(
        BARE._replace(viscous=0.1, laws=AxisLaws(regimes=(ViscousRegime(2.0, 0.5, 0.5),))),
        [1.2] * 50,
        period=10.0,
        state=_moving(3.0),
    )
    assert state[VELOCITY] == pytest.approx(2.0, rel=1e-9)


def _moving(speed: float) -> NDArray[np.float64]:
    state = rest()
    state[VELOCITY] = speed
    return state


@pytest.mark.parametrize(
    ("effort", "moves"), [(1.19, False), (1.21, True), (-1.49, False), (-1.51, True)]
)
def test_each_direction_has_its_breakaway(effort: float, moves: bool) -> None:
    p = BARE._replace(breakaway=1.2, laws=AxisLaws(backward=AxisFrictionLevels(0.0, 1.1, 1.5)))
    assert (run(p, [effort])[VELOCITY] != 0.0) == moves


@FAST
@given(
    x=st.floats(0.0, 63.0),
    direction=st.sampled_from([1.0, -1.0]),
    share=st.sampled_from([0.999, 1.001]),
)
def test_breakaway_follows_the_polynomials_of_table_4_7(
    x: float, direction: float, share: float
) -> None:
    """With the means of the published curves as levels, the thresholds are the curves
    themselves."""
    curve = FORWARD if direction > 0 else BACKWARD
    means = [float(np.polynomial.Polynomial(c).integ()(63.0)) / 63.0 for c in (FORWARD, BACKWARD)]
    laws = AxisLaws(backward=AxisFrictionLevels(0.0, means[1] / 1.1, means[1]), shape=MAP)
    p = TIGHT._replace(lag=0.0, coulomb=means[0] / 1.1, breakaway=means[0], laws=laws)
    threshold = sum(b * x**k for k, b in enumerate(curve))
    state = run(p, [direction * share * threshold / p.constant], state=rest(x))
    assert (state[VELOCITY] != 0.0) == (share > 1.0)


def test_the_stribeck_curve_is_felt_at_a_steady_speed() -> None:
    """Held by viscous friction where (2.34) balances the effort, on the rising branch."""
    p = BARE._replace(
        viscous=2.0, breakaway=1.5, laws=AxisLaws(stribeck_velocity=0.2, stribeck_exponent=1.0)
    )
    state = run(p, [1.0 + 0.5 * math.exp(-2.0) + 2.0 * 0.4], period=50.0, state=_moving(0.6))
    assert state[VELOCITY] == pytest.approx(0.4, rel=1e-8)


@pytest.mark.parametrize(
    ("rested", "moves"), [(0.0, True), (0.09, True), (0.11, False), (5.0, False)]
)
def test_breakaway_grows_with_the_time_at_rest(rested: float, moves: bool) -> None:
    """F_s 2 (1 - 0.5 tau/(tau + t)) with tau = 0.1 s is 1.5 N after 0.1 s."""
    p = BARE._replace(breakaway=2.0, laws=AxisLaws(fresh=0.5, rise_time=0.1))
    state = run(p, [0.0], period=rested)
    assert state[RESTED] == rested
    assert (run(p, [1.5], state=state)[VELOCITY] != 0.0) == moves


def test_the_clock_of_the_rest_starts_anew_at_a_stop() -> None:
    p = BARE._replace(breakaway=2.0, laws=AxisLaws(fresh=0.5, rise_time=0.1))
    state = run(p, [0.0], period=3.0, state=_moving(2.0))  # stops after 2 s
    assert state[RESTED] == pytest.approx(1.0, rel=1e-12)


@FAST
@given(
    full=st.floats(0.1, 2.0),
    fresh=st.floats(0.3, 1.0),
    rise=st.floats(1e-4, 1.0),
    rested=st.one_of(st.just(0.0), st.floats(0.0, 1.0)),
    start=st.floats(0.0, 0.99),
    settled=st.floats(0.5, 3.0),
    lag=st.floats(1e-4, 1.0),
)
def test_the_drive_outgrows_the_breakaway_first_where_it_does(
    full: float, fresh: float, rise: float, rested: float, start: float, settled: float, lag: float
) -> None:
    """Against dense sampling of the margin."""

    def missing(t: float) -> float:
        return (
            full * (1.0 - (1.0 - fresh) * rise / (rise + rested + t))
            - settled
            + losing * math.exp(-t / lag)
        )

    below = start * full * (1.0 - (1.0 - fresh) * rise / (rise + rested))
    losing, duration = settled - below, 5.0 * lag
    if losing <= 0.0:
        return
    found = outgrowing_time(full, fresh, rise, rested, settled, losing, lag, duration)
    margins = np.array(
        [missing(t) for t in np.linspace(0.0, duration if found == NEVER else found, 2000)]
    )
    assert margins[:-1].min() > -1e-9 * full
    assert found == NEVER or abs(margins[-1]) <= 1e-12 * (full + settled)


@example(  # stops within a part of the work's quadrature
    p=CLUTCH._replace(laws=LAWS["dwell"], lag=3e-4, backlash=0.0, breakaway=0.115),
    commands=[20.125, 0.0, 30.0, -43.625, 0.0, -43.75, 25.75, -0.1875, 0.0],
)
@given(p=RICH, commands=COMMANDS)
def test_friction_and_stops_never_create_energy(p: AxisParameters, commands: list[float]) -> None:
    """Work of the effort minus kinetic energy is at least the least Coulomb loss over the way,
    through every event."""
    array, state, parts = p.as_array(), rest(4.5), 100
    levels = [coulomb(p, d, x) for d in (1.0, -1.0) for x in np.linspace(-60.0, 70.0, 261)]
    least = min([*levels, p.backlash_coulomb] if p.backlash else levels)
    if p.laws.stops[1] < 4.5:
        state[POSITION] = state[LOAD_POSITION] = 0.0
    for command in commands:
        kinetic, work, slack, way = 0.5 * p.inertia * state[VELOCITY] ** 2, 0.0, 1e-15, 0.0
        for _ in range(parts):
            x, effort, moved = (
                state[POSITION],
                p.constant * (state[DRIVE] if p.lag > 0 else command) - p.offset,
                state[VELOCITY] != 0.0,
            )
            assert advance(state, command, array, 4e-3 / parts) == OK
            after, step = p.constant * state[DRIVE] - p.offset, state[POSITION] - x
            work, way = work + 0.5 * (effort + after) * step, way + abs(step)
            # by trapezoids; an axis that rests at one end may have moved in any part of the time,
            # under an effort between the two
            slack += abs(step) * (
                1e-3 * abs(effort + after)
                if moved and state[VELOCITY] != 0.0
                else 0.5 * abs(after - effort)
            )
        lost = work - (0.5 * p.inertia * state[VELOCITY] ** 2 - kinetic)
        assert lost >= least * way - slack
        assert p.laws.stops[0] <= state[POSITION] <= p.laws.stops[1]
        assert state[POSITION] - state[LOAD_POSITION] == pytest.approx(state[GAP], abs=1e-12)
        assert abs(state[GAP]) <= 0.5 * p.backlash


@given(p=RICH, commands=COMMANDS, parts=st.integers(2, 5))
def test_a_sample_in_parts_is_the_same_sample(
    p: AxisParameters, commands: list[float], parts: int
) -> None:
    whole, state, array = rest(2.5), rest(2.5), p.as_array()
    for command in commands:
        assert advance(whole, command, array, 5e-3) == OK
        for _ in range(parts):
            assert advance(state, command, array, 5e-3 / parts) == OK
    np.testing.assert_allclose(state[:5], whole[:5], rtol=1e-6, atol=1e-7)


@FAST
@given(commands=COMMANDS)
def test_laws_that_change_nothing_change_no_bit(commands: list[float]) -> None:
    """Stops out of reach, equal directions: the closed forms of the plain axis."""
    wide = CLUTCH._replace(
        laws=AxisLaws(
            backward=AxisFrictionLevels(CLUTCH.viscous, CLUTCH.coulomb, CLUTCH.breakaway),
            stops=(-1e9, 1e9),
        )
    )
    np.testing.assert_array_equal(
        run(wide, commands, 3e-3)[:RESTED], run(CLUTCH, commands, 3e-3)[:RESTED]
    )
