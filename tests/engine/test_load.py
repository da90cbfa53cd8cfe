"""An axis under a spring, gravity and ripple against scipy (sticking, breakaways, end stops,
backlash) and against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.bench_experiment import play_reference
from frictool.engine.bench_position_loop import PositionServo
from frictool.engine.closed_loop import RECORD_SIZE, TRUE_POSITION, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.plant.axis import DRIVE, GAP, POSITION, RESTED, STUCK, VELOCITY, AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisLaws
from frictool.plant.position_load import LoadHarmonic, PositionLoad, load_effort, with_load
from studies.references.event_integration import event_integration
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller, speed_controller, started
from tests.support.axis_runs import CLUTCH

PERIOD = 1e-3
EXACT = 1e-7  # rad


def drawn_axis(draw: np.random.Generator) -> tuple[AxisParameters, PositionLoad]:
    """A clutch with friction, backlash, end stops and Stribeck curve of one kind or another, and a
    load as large as its friction."""
    coulomb = float(draw.uniform(0.02, 0.1))
    stops = (
        (-float(draw.uniform(0.05, 0.5)), float(draw.uniform(0.05, 0.5)))
        if draw.random() < 0.5
        else (-math.inf, math.inf)
    )
    laws = AxisLaws(
        stribeck_velocity=float(draw.uniform(1.0, 5.0)) if draw.random() < 0.3 else 0.0,
        stops=stops,
        restitution=float(draw.uniform(0.0, 0.6)),
    )
    axis = CLUTCH._replace(
        viscous=float(draw.choice([0.0, 3.8e-4])),
        coulomb=coulomb,
        breakaway=coulomb * float(draw.uniform(1.0, 1.5)),
        lag=float(draw.choice([0.0, 3e-3])),
        backlash=float(draw.choice([0.0, 0.1])),
        backlash_coulomb=0.2 * coulomb,
        backlash_breakaway=0.25 * coulomb,
        laws=laws if draw.random() < 0.7 else AxisLaws(),
    )
    waves = tuple(
        LoadHarmonic(
            float(draw.choice([1.0, 7.0, 40.0])),
            float(draw.uniform(-0.1, 0.1)),
            float(draw.uniform(-0.1, 0.1)),
        )
        for _ in range(draw.integers(0, 3))
    )
    return axis, PositionLoad(
        float(draw.choice([0.0, -0.05, 0.3, 3.0])) if waves else float(draw.uniform(0.1, 5.0)),
        waves,
    )


@pytest.mark.parametrize(
    "seed", [*range(12), *(pytest.param(k, marks=pytest.mark.accept) for k in range(12, 40))]
)
def test_a_load_is_integrated_as_exactly_as_friction(seed: int) -> None:
    """Twelve commands of 5 ms follow one another, each from the engine's state: sticking,
    breakaway, reversal, flanks and end stops."""
    draw = np.random.default_rng([17, seed])
    axis, load = drawn_axis(draw)
    state, array = rest(), with_load(axis.as_array(), load.as_array())
    for command in draw.uniform(-20.0, 20.0, 12) * draw.choice([0.0, 1.0], 12, p=[0.25, 0.75]):
        expected = event_integration(axis, state, float(command), 5 * PERIOD, load=load)
        for _ in range(5):
            assert advance(state, command, array, PERIOD) == OK
        assert state[POSITION] == pytest.approx(expected[0], rel=0.0, abs=EXACT)
        assert state[VELOCITY] == pytest.approx(expected[1], rel=1e-7, abs=1e-5)
        assert state[DRIVE] == pytest.approx(expected[2], rel=1e-9, abs=1e-9)
        assert state[GAP] == pytest.approx(expected[3], rel=0.0, abs=EXACT)


def test_the_drawn_axes_meet_every_event() -> None:
    """The sample above has axes that stick, slip, bounce and cross their backlash, or it would show
    less than it says."""
    stuck = moved = bounced = crossed = 0
    for seed in range(40):
        draw = np.random.default_rng([17, seed])
        axis, load = drawn_axis(draw)
        state, array = rest(), with_load(axis.as_array(), load.as_array())
        for command in draw.uniform(-20.0, 20.0, 12) * draw.choice([0.0, 1.0], 12, p=[0.25, 0.75]):
            for _ in range(5):
                before = state.copy()
                assert advance(state, command, array, PERIOD) == OK
                stuck += state[RESTED] >= PERIOD and state[VELOCITY] == 0.0
                moved += state[POSITION] != before[POSITION]
                bounced += any(abs(state[POSITION] - wall) < 0.02 for wall in axis.laws.stops)
                crossed += state[GAP] != before[GAP]
    assert min(stuck, moved, bounced, crossed) > 50


@pytest.mark.parametrize("period", [8e-3, 2e-3])
def test_a_mass_on_a_spring_swings_as_its_closed_form(period: float) -> None:
    """The result does not depend on the sample period: a spring of 400 N/m and 1 kg for a
    second."""
    mass, load, samples = (
        AxisParameters(1.0, 0.0, 0.0, 0.0, drive_limit=1e-12),
        PositionLoad(stiffness=400.0).as_array(),
        round(1.0 / period) + 1,
    )
    record = np.zeros((samples, RECORD_SIZE))
    own = started(CONTROLLER, 0.01)
    assert (
        run(
            mass.as_array(),
            rest(0.01),
            own,
            np.zeros(samples),
            period,
            0,
            record,
            load,
            NO_CONDITIONS,
        )
        == OK
    )
    expected = 0.01 * np.cos(20.0 * period * np.arange(samples))
    np.testing.assert_allclose(record[:, TRUE_POSITION], expected, rtol=0.0, atol=1e-10)


def test_a_mass_on_a_spring_stops_after_the_half_swings_of_its_closed_form() -> None:
    """Each half swing takes pi sqrt(m/k) and loses 2 F/k of amplitude; the mass stays within F/k of
    the spring's rest."""
    stiffness, coulomb, start = 400.0, 0.3, 0.01
    mass = AxisParameters(1.0, 0.0, coulomb, coulomb)
    state, array = (
        rest(start),
        with_load(mass.as_array(), PositionLoad(stiffness=stiffness).as_array()),
    )
    half = math.pi / 20.0
    lost = 2.0 * coulomb / stiffness
    for swing in range(1, 7):
        assert advance(state, 0.0, array, half) == OK
        assert state[POSITION] == pytest.approx((-1) ** swing * (start - swing * lost), abs=1e-12)
    assert advance(state, 0.0, array, 10.0) == OK
    assert abs(state[POSITION]) <= coulomb / stiffness
    assert state[VELOCITY] == STUCK == 0.0


def test_a_pendulum_keeps_its_energy() -> None:
    """Gravity alone, large swings: kinetic and potential energy stay what they were."""
    arm, load = (
        AxisParameters(0.02, 0.0, 0.0, 0.0),
        PositionLoad(0.0, (LoadHarmonic(1.0, 1.5, 0.0),)),
    )
    state, array = rest(2.8), with_load(arm.as_array(), load.as_array())
    for _ in range(3000):
        assert advance(state, 0.0, array, PERIOD) == OK
        energy = 0.5 * 0.02 * state[VELOCITY] ** 2 - 1.5 * math.cos(state[POSITION])
        assert energy == pytest.approx(-1.5 * math.cos(2.8), abs=1e-9)


def test_parts_of_a_call_are_the_whole() -> None:
    """Halving every call changes a run by less than the tolerance of the integration."""
    load = PositionLoad(0.3, (LoadHarmonic(7.0, 0.05, -0.02),)).as_array()
    array = with_load(CLUTCH._replace(backlash=0.1).as_array(), load)
    whole, halves = rest(), rest()
    for command in np.random.default_rng(3).uniform(-20.0, 20.0, 100):
        assert advance(whole, command, array, 4 * PERIOD) == OK
        assert advance(halves, command, array, 2 * PERIOD) == OK
        assert advance(halves, command, array, 2 * PERIOD) == OK
    np.testing.assert_allclose(halves[:3], whole[:3], rtol=1e-8, atol=1e-9)


def test_a_load_of_zero_is_no_load() -> None:
    """AxisLaws that change nothing, and a load of size zero, leave the motion of the plain axis but
    for rounding."""
    plain, loaded = rest(), rest()
    array = CLUTCH.as_array()
    with_zero = with_load(array, np.zeros(1))
    np.testing.assert_array_equal(with_load(array, np.empty(0)), array)
    for command in np.random.default_rng(4).uniform(-20.0, 20.0, 200):
        assert advance(plain, command, array, PERIOD) == OK
        assert advance(loaded, command, with_zero, PERIOD) == OK
    np.testing.assert_allclose(
        loaded[:RESTED], plain[:RESTED], rtol=1e-9, atol=1e-9
    )  # the plain axis counts no rest


def test_the_bench_loop_holds_no_load_over_a_period() -> None:
    """Without gains the bench's loop leaves a pendulum alone, which then swings as in ever shorter
    periods."""
    arm, load = (
        AxisParameters(0.02, 0.0, 0.0, 0.0),
        PositionLoad(0.0, (LoadHarmonic(1.0, 1.5, 0.0),)).as_array(),
    )
    found: list[NDArray[np.float64]] = []
    for parts in (1, 8):
        samples = 100 * parts + 1
        position, drive, servo = np.zeros(samples), np.zeros(samples), np.array(PositionServo(0.0))
        assert (
            play_reference(
                arm.as_array(),
                load,
                rest(1.0),
                servo,
                np.zeros(samples),
                1e-2 / parts,
                0,
                position,
                drive,
            )
            == OK
        )
        found.append(position[::parts])
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-10)
    assert np.ptp(found[0]) > 1.5


def test_opposing_terms_add_up() -> None:
    load = PositionLoad(0.5, (LoadHarmonic(2.0, 0.1, 0.2), LoadHarmonic(5.0, -0.3, 0.0)))
    places = np.linspace(-3.0, 3.0, 50)
    np.testing.assert_allclose(
        [load_effort(load.as_array(), x) for x in places], load.at(places), rtol=1e-14
    )


CONTROLLER = clutch_controller(BRAKE_LAW, speed=speed_controller())
