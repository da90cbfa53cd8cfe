"""The event-exact engine on the mass of table 3.1: the tests of 3.7 against an integrator, and what
must hold of any run."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from frictool.engine.body import (
    BOUNCES,
    BREAKS_AWAY,
    MASS,
    PASSES_KNEE,
    RESTS_AT_STOP,
    SLIPS_BACK,
    STOPS,
    moving,
)
from frictool.engine.drive import EffortFunction, held, pid, ramped, spring
from frictool.engine.status_codes import EVENTS_FULL, NOT_FINITE
from frictool.engine.stick_slip import pieces_allowed
from frictool.engine.stick_slip_run import simulate
from studies.references.stick_slip import (
    BREAKAWAY,
    COULOMB,
    STRIBECK_SPEED,
    VISCOUS,
    reference_breakaways,
    table31,
)
from tests.engine.drives import drives, ok

SPRING = spring(stiffness=2.0, speed=0.1)
PID = pid(proportional=3.0, derivative=6.0, integral=4.0, target=1.0)


def test_stick_slip_of_table_3_1() -> None:
    run = ok(simulate(table31(), [(60.0, SPRING)], np.linspace(0.0, 60.0, 60_001)))
    breakaways, stops = run.times_of(BREAKS_AWAY), run.times_of(STOPS)
    assert breakaways.size == 9
    assert breakaways[0] == pytest.approx(7.5, abs=1e-12)  # F_s / (K w)
    np.testing.assert_allclose(np.diff(breakaways), 6.5123, atol=1e-4)
    positions = run.events[run.events[:, 1] == STOPS, 2]
    np.testing.assert_allclose(np.diff(positions, prepend=0.0), 0.6512, atol=1e-4)
    assert np.mean(np.abs(run.velocity) < STRIBECK_SPEED) == pytest.approx(0.621, abs=1e-3)
    assert np.mean(run.mode == 0.0) == pytest.approx(0.6146, abs=1e-4)  # at rest, not only slow
    assert run.velocity.max() == pytest.approx(0.381, abs=1e-3)
    assert np.all(stops[:8] < breakaways[1:])


@pytest.mark.parametrize(("drive", "end"), [(SPRING, 25.0), (PID, 40.0), (ramped(0.0, 0.4), 6.0)])
def test_breakaways_agree_with_an_integrator(drive: EffortFunction, end: float) -> None:
    expected, last = reference_breakaways(table31(), drive, end)
    run = ok(simulate(table31(), [(end, drive)], [end]))
    found = np.concatenate([run.times_of(BREAKS_AWAY), run.times_of(SLIPS_BACK)])
    assert len(expected) >= 1
    np.testing.assert_allclose(np.sort(found), expected, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(run.state[:3], last, rtol=1e-6, atol=1e-7)


def test_limit_cycle() -> None:
    run = ok(simulate(table31(), [(300.0, PID)], np.linspace(200.0, 300.0, 100_001)))
    assert 0.5 * np.ptp(run.position) == pytest.approx(0.0669, abs=5e-5)
    assert 2.0 * np.diff(run.times_of(BREAKS_AWAY))[-1] == pytest.approx(23.73, abs=0.005)


def test_a_tighter_tolerance_is_nearer() -> None:
    exact, _ = reference_breakaways(table31(), SPRING, 25.0)
    errors = [
        float(
            np.max(
                np.abs(
                    simulate(table31(tolerance=tolerance), [(25.0, SPRING)], []).times_of() - exact
                )
            )
        )
        for tolerance in (1e-2, 1e-5, 1e-8)
    ]
    assert errors[0] > 10.0 * errors[1] > 100.0 * errors[2]


@given(
    effort=st.floats(-BREAKAWAY, BREAKAWAY),
    swing=st.floats(0.0, 1.0),
    frequency=st.floats(0.01, 100.0),
)
def test_below_breakaway_nothing_moves(effort: float, swing: float, frequency: float) -> None:
    below = effort * (1.0 - 1e-12)
    drive = EffortFunction(
        offset=below * (1.0 - swing), amplitude=swing * below, frequency=frequency
    )
    run = ok(simulate(table31(), [(100.0, drive)], np.linspace(0.0, 100.0, 101)))
    assert run.events.size == 0
    assert np.all(run.position == 0.0)
    assert np.all(run.velocity == 0.0)


def test_the_drift_test_of_3_7_5_does_not_drift() -> None:
    segments = [(1.0, ramped(0.0, 1.6)), (1.05, ramped(1.6, -22.0, start=1.0)), (2.0, held(0.5))]
    segments.append(
        (
            102.0,
            EffortFunction(offset=0.5, amplitude=0.4, frequency=4.0 * np.pi, phase=-8.0 * np.pi),
        )
    )
    run = ok(simulate(table31(), segments, np.linspace(5.0, 102.0, 1000)))
    assert run.times_of(BREAKS_AWAY).tolist() == pytest.approx([BREAKAWAY / 1.6])
    assert np.ptp(run.position) == 0.0
    assert run.position[0] > 0.0


# breaks away at 3.39 s, where one rounding of the time is more of the effort than one rounding of
# the effort
@example(
    first=EffortFunction(
        amplitude=2.0, frequency=10.0, phase=2.0, proportional=1.0, derivative=1.0, integral=1.0
    ),
    second=EffortFunction(
        amplitude=3.0, frequency=8.0, phase=1.5, proportional=0.125, derivative=2.0, integral=1.0
    ),
    start=1.0,
    restitution=0.0,
)
@given(
    first=drives, second=drives, start=st.floats(-1.0, 1.0), restitution=st.sampled_from([0.0, 0.7])
)
def test_energy_is_never_created(
    first: EffortFunction, second: EffortFunction, start: float, restitution: float
) -> None:
    """Friction and end stops take: the kinetic energy gained is at most the work of the effort
    (3.42), through every switch."""
    body = table31(stops=(-3.0, 3.0), restitution=restitution)
    times = np.linspace(0.0, 4.0, 40_001)
    run = ok(simulate(body, [(2.0, first), (4.0, second)], times, state=moving(0.0, start)))
    assert np.all(run.friction * run.velocity >= 0.0)
    assert np.all(np.abs(run.position) <= 3.0)
    held_still = run.mode == 0.0
    assert np.all(run.velocity[held_still] == 0.0)
    power = run.effort * run.velocity
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(times))])
    kinetic = 0.5 * run.velocity**2
    trapezoid = 1e-4 * np.max(np.abs(power)) * (3 + run.events.shape[0])
    assert np.all(kinetic <= kinetic[0] + work + trapezoid)


@given(drive=drives, start=st.floats(-1.0, 1.0))
def test_parts_make_the_whole(drive: EffortFunction, start: float) -> None:
    """Cut anywhere, a run goes on as it would have; an odd law and a mirrored drive give a mirrored
    run."""
    whole = ok(simulate(table31(), [(3.0, drive)], [3.0], state=moving(0.0, start)))
    parts = ok(
        simulate(
            table31(), [(0.7, drive), (1.9, drive), (3.0, drive)], [3.0], state=moving(0.0, start)
        )
    )
    np.testing.assert_allclose(parts.state[:3], whole.state[:3], rtol=1e-5, atol=1e-6)
    mirror = EffortFunction(
        -drive.offset,
        -drive.slope,
        -drive.amplitude,
        *drive[3:8],
        -drive.target,
        -drive.target_speed,
    )
    mirrored = ok(simulate(table31(), [(3.0, mirror)], [3.0], state=moving(0.0, -start)))
    np.testing.assert_allclose(mirrored.state[:3], -whole.state[:3], rtol=0.0, atol=1e-12)


def test_an_effort_exactly_on_the_threshold_sticks_and_a_rising_one_does_not() -> None:
    assert ok(simulate(table31(), [(10.0, held(BREAKAWAY))], [10.0])).events.size == 0
    rising = ok(simulate(table31(), [(1.0, ramped(BREAKAWAY, 1e-3))], [1.0]))
    assert rising.times_of().tolist() == [0.0]
    assert rising.position[0] > 0.0


def test_a_reversal_under_a_strong_effort_does_not_stick() -> None:
    run = ok(simulate(table31(), [(2.0, held(-3.0))], [2.0], state=moving(0.0, 0.5)))
    assert [int(kind) for kind in run.events[:, 1] if kind in (STOPS, SLIPS_BACK)] == [
        STOPS,
        SLIPS_BACK,
    ]
    assert run.velocity[0] < -1.0


def test_coasting_to_a_stop_by_hand() -> None:
    """Coulomb and viscous friction alone: v(t) = (v0 + a/s) e^{-s t} - a/s with a = F_c/m, s =
    sigma_v/m."""
    law = np.array([COULOMB, COULOMB, 1.0, 2.0, VISCOUS])
    body = table31(law=law, breakaway=(COULOMB, COULOMB), straight_from=0.0)
    run = ok(simulate(body, [(5.0, held(0.0))], [5.0], state=moving(0.0, 2.0)))
    stop = np.log1p(VISCOUS * 2.0 / COULOMB) / VISCOUS
    assert run.times_of(STOPS).tolist() == pytest.approx([stop], rel=1e-14)
    assert run.position[0] == pytest.approx((2.0 - COULOMB * stop) / VISCOUS, rel=1e-13)


def test_the_knee_changes_the_viscous_friction_beyond_it() -> None:
    body = table31(knee=0.5, viscous_beyond=(0.0, 0.0))
    run = ok(simulate(body, [(20.0, held(1.6))], [20.0]))
    passed = run.times_of(PASSES_KNEE)
    assert passed.size == 1
    assert run.velocity[0] == pytest.approx(
        0.5 + (1.6 - COULOMB - VISCOUS * 0.5) * (20.0 - passed[0]), rel=1e-9
    )
    assert run.friction[0] == pytest.approx(COULOMB + VISCOUS * 0.5, rel=1e-12)


@pytest.mark.parametrize("speed", [0.8, 2.0])
def test_coasting_down_through_the_knee_by_hand(speed: float) -> None:
    """Beyond the knee friction is constant, a uniform braking; below it as without a knee."""
    knee = 0.5
    law = np.array([COULOMB, COULOMB, 1.0, 2.0, VISCOUS])
    body = table31(
        law=law,
        breakaway=(COULOMB, COULOMB),
        straight_from=0.0,
        knee=knee,
        viscous_beyond=(0.0, 0.0),
    )
    run = ok(simulate(body, [(5.0, held(0.0))], [5.0], state=moving(0.0, speed)))
    passed = (speed - knee) / (COULOMB + VISCOUS * knee)
    stop = passed + np.log1p(VISCOUS * knee / COULOMB) / VISCOUS
    assert run.times_of(PASSES_KNEE).tolist() == pytest.approx([passed], rel=1e-12)
    assert run.times_of(STOPS).tolist() == pytest.approx([stop], rel=1e-11)


def test_a_ball_between_end_stops_comes_to_rest() -> None:
    """Rebounds shorten without end: the rule ends them, and says so."""
    body = table31(stops=(-1.0, 0.2), restitution=0.5)
    run = ok(simulate(body, [(10.0, held(2.5))], [10.0]))
    assert run.times_of(BOUNCES).size > 5
    assert run.times_of(RESTS_AT_STOP).size == 1
    assert run.position[0] == 0.2
    assert run.velocity[0] == 0.0
    assert run.friction[0] == BREAKAWAY  # the stop holds the rest
    back = ok(simulate(body, [(11.0, held(-2.5))], [11.0], state=run.state, start=10.0))
    assert back.position[0] < 0.2


def test_a_run_without_room_for_its_events_says_so() -> None:
    run = simulate(table31(), [(60.0, SPRING)], np.linspace(0.0, 60.0, 61), most_events=3)
    assert run.status == EVENTS_FULL
    assert run.events.shape[0] == 3
    assert 7.5 < run.reached < 14.0
    assert np.all(np.isnan(run.position[run.time > run.reached]))
    assert not np.any(np.isnan(run.position[run.time < run.reached]))


def test_a_state_that_is_not_finite_is_refused() -> None:
    run = simulate(table31(), [(1.0, SPRING)], [1.0], state=moving(0.0, np.nan))
    assert (run.status, run.reached) == (NOT_FINITE, 0.0)


def test_a_peak_that_touches_the_threshold_ends_and_moves_nothing() -> None:
    for phase in np.linspace(0.0, 6.0, 40):
        run = ok(
            simulate(
                table31(),
                [(20.0, EffortFunction(amplitude=BREAKAWAY, frequency=3.0, phase=float(phase)))],
                [20.0],
            )
        )
        assert abs(run.position[0]) < 1e-20


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": 0.0}, "mass"),
        ({"breakaway": (0.5, 0.5)}, "breakaway"),
        ({"coulomb": (-1.0, 1.0)}, "friction"),
        ({"tolerance": 1.0}, "tolerance"),
        ({"restitution": 1.0}, "restitution"),
        ({"stops": (1.0, 0.0)}, "stops: found"),
        ({"knee": 1e-4}, "knee"),
    ],
)
def test_a_body_that_is_none_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        table31(**change).as_array()


def test_segments_and_times_in_order() -> None:
    with pytest.raises(ValueError, match="segments"):
        simulate(table31(), [(1.0, SPRING), (1.0, SPRING)], [])
    with pytest.raises(ValueError, match="times"):
        simulate(table31(), [(1.0, SPRING)], [2.0])
    with pytest.raises(ValueError, match="finite"):
        simulate(table31(), [(1.0, EffortFunction(offset=np.nan))], [])


@pytest.mark.parametrize("gain", ["proportional", "derivative", "integral", "frequency"])
def test_the_limit_of_pieces_grows_with_every_rate_and_with_the_length_of_the_run(
    gain: str,
) -> None:
    """A faster loop has more events, which an endless cycle must not be mistaken for."""
    body = table31(straight_from=0.0).as_array()

    def allowed(value: float, span: float = 10.0, events: int = 5) -> float:
        return pieces_allowed(body, EffortFunction(**{gain: value}).as_array(), span, events)

    rates = [allowed(value) for value in (0.0, 1.0, 8.0, 1e3)]
    assert all(one < other for one, other in itertools.pairwise(rates))
    assert allowed(8.0, span=20.0) > allowed(8.0)
    assert allowed(8.0, events=6) > allowed(8.0)
    root = {"proportional": 0.5, "integral": 1.0 / 3.0}.get(gain, 1.0)
    # each rate of the loop comes a hundred times in the limit
    mass = float(body[MASS]) if gain != "frequency" else 1.0
    assert rates[2] - rates[0] == pytest.approx(100.0 * (8.0 / mass) ** root * 10.0)
