"""The composed controller: bit-equal to the plain one on any input, bounded, at rest where the design says rest."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.control.band import BRAKE, REST, RUN
from frictool.control.cascade import ETA, FILTERED, FILTERED_SPEED, LIMITED, MODE, X, control_step, initial_state
from frictool.control.packing import pack
from frictool.documents.controller import Controller, LinearController, StateSpace
from tests.control.example import BRAKE_LAW, CUT_LAW, clutch_controller
from tests.control.plain import PlainController

STEP = 2 * math.pi / 56
NAMES = {RUN: "run", BRAKE: "brake", REST: "rest"}
LAWS = {"cut": CUT_LAW, "brake": BRAKE_LAW}

controllers = st.builds(
    clutch_controller, st.sampled_from([CUT_LAW, BRAKE_LAW]), prefilter=st.booleans(), limit=st.sampled_from([0.5, 50.0])
)


def random_controller(order: int, seed: int) -> LinearController:
    """Any stable a and stable a - l c: coefficients for arithmetic, not for a loop."""
    random = np.random.default_rng(seed)
    a = random.standard_normal((order, order))
    a *= 0.9 / max(1.0, float(np.max(np.abs(np.linalg.eigvals(a))))) if order else 1.0
    rows = [tuple(tuple(map(float, row)) for row in matrix) for matrix in (a, random.standard_normal((order, 1)))]
    c = (tuple(map(float, random.standard_normal(order))),)
    space = StateSpace(rows[0], rows[1], c, ((float(random.standard_normal()),),))
    return LinearController(discrete=space, continuous=space, sos=(), anti_windup=(0.0,) * order)


@st.composite
def inputs(draw: st.DrawFn) -> tuple[float, list[tuple[float, float]]]:
    """A start, then references held for a while and positions that wander by counts, with rests in between."""
    start = STEP * draw(st.integers(0, 400))
    samples, position = [], start
    for _ in range(draw(st.integers(1, 6))):
        reference = draw(st.one_of(st.floats(0.0, 63.0), st.just(position), st.floats(position - 2.0, position + 2.0)))
        seed, speed = draw(st.integers(0, 2**16)), draw(st.sampled_from([0, 0, 1, 3]))
        random = np.random.default_rng(seed)
        for move in random.integers(-speed, speed + 1, 50):
            position += STEP * float(move)
            samples.append((reference, position))
    return start, samples


@settings(max_examples=200)
@given(controllers, st.integers(0, 4), st.integers(0, 2**16), inputs())
def test_equals_the_plain_controller_bit_by_bit(
    controller: Controller, order: int, seed: int, sequence: tuple[float, list[tuple[float, float]]]
) -> None:
    controller = msgspec.structs.replace(controller, linear=random_controller(order, seed))
    start, samples = sequence
    plain = PlainController(controller, start)
    parameters = pack(controller)
    state = initial_state(parameters, start)
    for reference, position in samples:
        drive = control_step(parameters, state, reference, position)
        assert drive == plain.step(reference, position)
        assert NAMES[state[MODE]] == plain.mode
        assert (state[FILTERED], state[ETA], state[LIMITED]) == (plain.r, plain.eta, plain.limited)
        assert list(state[X : X + order]) == plain.x


@settings(max_examples=30)
@given(controllers, inputs())
def test_is_bounded_and_rest_is_exactly_zero(controller: Controller, sequence: tuple[float, list[tuple[float, float]]]) -> None:
    start, samples = sequence
    parameters = pack(controller)
    state = initial_state(parameters, start)
    for reference, position in samples:
        drive = control_step(parameters, state, reference, position)
        assert abs(drive) <= controller.drive_limit
        if state[MODE] == REST:
            assert drive == 0.0
            assert math.copysign(1.0, drive) == 1.0
            assert abs(state[FILTERED] - position) <= controller.position_law.band


@pytest.mark.parametrize("law", LAWS)
def test_starts_at_rest_and_stays_there(law: str) -> None:
    parameters = pack(clutch_controller(LAWS[law]))
    state = initial_state(parameters, 7.5)
    before = state.copy()
    assert [control_step(parameters, state, 7.5, 7.5) for _ in range(100)] == [0.0] * 100
    np.testing.assert_array_equal(state, before)


@pytest.mark.parametrize("law", LAWS)
def test_is_symmetric(law: str) -> None:
    """The mirrored inputs give the mirrored drive."""
    parameters = pack(clutch_controller(LAWS[law]))
    one, other = initial_state(parameters, 0.0), initial_state(parameters, 0.0)
    position = 0.0
    for _ in range(600):
        assert control_step(parameters, one, 20.0, position) == -control_step(parameters, other, -20.0, -position)
        position = STEP * math.floor((0.1 * one[FILTERED] + 0.9 * position) / STEP)


def test_resumes_from_rest_as_from_the_start() -> None:
    """What was before a rest leaves no trace but the prefilter's and the encoder's own state."""
    controller = clutch_controller(CUT_LAW, prefilter=False)
    parameters = pack(controller)
    used, new = initial_state(parameters, 0.0), initial_state(parameters, 30.0)
    for position in np.linspace(0.0, 30.0, 300):
        control_step(parameters, used, 30.0, float(position))
    assert control_step(parameters, used, 30.0, 30.0) == 0.0
    assert used[MODE] == REST
    for _ in range(50):
        assert control_step(parameters, used, 40.0, 30.0) == control_step(parameters, new, 40.0, 30.0)


def test_waits_for_the_prefilter_before_it_lets_go() -> None:
    """An axis that follows the filtered reference exactly is inside the band all the way, and must not be dropped there."""
    parameters = pack(clutch_controller(CUT_LAW))
    state = initial_state(parameters, 5.0)
    modes, moving = [], []
    for _ in range(600):
        control_step(parameters, state, 55.0, float(state[FILTERED]))
        modes.append(state[MODE])
        moving.append(abs(state[FILTERED_SPEED]) >= CUT_LAW.settled_speed)
    assert modes == [RUN if moves else REST for moves in moving]
    assert sum(moving) > 150
    assert modes[-1] == REST


def test_brakes_before_it_rests() -> None:
    """In the band at speed: the loop stays closed with a speed reference of zero, then the drive is zero for good."""
    controller = clutch_controller(BRAKE_LAW, prefilter=False)
    parameters = pack(controller)
    state = initial_state(parameters, 0.0)
    modes, position, speed = [], -20.0, 300.0
    drives = []
    state = initial_state(parameters, position)
    for _ in range(400):
        drives.append(control_step(parameters, state, 0.0, position))
        modes.append(state[MODE])
        speed = speed if position < -0.9 else 0.97 * speed
        position += 1e-3 * speed if position < 0.3 else 0.0
    order = [mode for index, mode in enumerate(modes) if index == 0 or modes[index - 1] != mode]
    assert order == [RUN, BRAKE, REST]
    braking = [drive for drive, mode in zip(drives, modes, strict=True) if mode == BRAKE]
    assert min(braking) < 0.0
    assert drives[-1] == 0.0


def test_blocked_axis_does_not_wind_up() -> None:
    """Held against the far reference for 1 s or for 3 s, the drive leaves its limit equally soon after the reference returns."""
    controller = clutch_controller(CUT_LAW, prefilter=False)
    parameters = pack(controller)

    def samples_at_limit_after(blocked: int) -> int:
        state = initial_state(parameters, 0.0)
        for _ in range(blocked):
            drive = control_step(parameters, state, 50.0, 0.0)
        assert drive == controller.drive_limit
        count = 0
        while control_step(parameters, state, -50.0, 0.0) > 0.0:
            count += 1
        return count

    short, long = samples_at_limit_after(1000), samples_at_limit_after(3000)
    assert short == long < 20
