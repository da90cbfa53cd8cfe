"""Blocks before the linear controller: each against another form of it, and the properties that the
design relies on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import signal

from frictool.control import drive_limit
from frictool.control.eta_integral import next_eta
from frictool.control.position_law import proportional_law, square_root_law
from frictool.control.prefilter import bounds, prefilter
from frictool.control.program import Program, ProgramNode
from frictool.control.speed_filter import velocity
from frictool.control.target_band import BRAKE, REST, RUN, is_settled, next_mode
from tests.support.single_block import Block
from tests.support.single_block import given as input_of

PERIOD = 1e-3
numbers = st.floats(-1e3, 1e3)
positive = st.floats(1e-6, 1e6)


def _filtered(
    w: float, m: float, reference: list[float], start: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(filtered, its speed), from rest at `start`."""
    block = Block(
        lambda program: prefilter(program, input_of(program, "reference"), w, m, PERIOD)[0]
    )
    block.set(reference_before=start, filtered_before=start)
    rows = np.array([(block.step(reference=r), block.value("filtered_speed")) for r in reference])
    return rows[:, 0], rows[:, 1]


@given(st.floats(1.0, 500.0), st.floats(0.2, 2.0), st.lists(numbers, min_size=1, max_size=60))
def test_prefilter_is_the_tustin_form_of_5_69(w: float, m: float, reference: list[float]) -> None:
    numerator, denominator = signal.bilinear([1.0], [1 / w**2, 2 * m / w, 1.0], 1 / PERIOD)
    filtered, speed = _filtered(w, m, reference)
    scale = max(1.0, max(abs(r) for r in reference))
    np.testing.assert_allclose(
        filtered, signal.lfilter(numerator, denominator, reference), atol=1e-9 * scale
    )
    # and its speed is that of s/(..), sampled the same way
    numerator, denominator = signal.bilinear([1.0, 0.0], [1 / w**2, 2 * m / w, 1.0], 1 / PERIOD)
    np.testing.assert_allclose(
        speed, signal.lfilter(numerator, denominator, reference), atol=1e-9 * w * scale
    )


@given(st.floats(5.0, 200.0), st.floats(0.7, 1.0))
def test_prefilter_has_unit_gain_and_its_own_time_constant(w: float, m: float) -> None:
    filtered, speed = _filtered(w, m, [1.0] * int(20 / (w * PERIOD)))
    assert filtered[-1] == pytest.approx(1.0, abs=1e-4)
    assert abs(speed[-1]) < 1e-3 * w
    overshoot = math.exp(-math.pi * m / math.sqrt(1.0 - m * m)) if m < 1.0 else 0.0
    assert max(filtered) == pytest.approx(1.0 + overshoot, abs=5e-3)
    # the area above the step response is the delay 2 m/w
    assert PERIOD * sum(1 - f for f in filtered) == pytest.approx(2 * m / w, abs=1.5 * PERIOD)


@given(numbers, st.floats(1.0, 500.0), st.floats(0.1, 2.0))
def test_settled_prefilter_does_not_move_by_a_bit(position: float, w: float, m: float) -> None:
    filtered, speed = _filtered(w, m, [position] * 5, start=position)
    assert filtered.tolist() == [position] * 5
    assert speed.tolist() == [0.0] * 5


@settings(max_examples=25)
@given(
    st.floats(2.0, 300.0),
    st.floats(0.4, 1.5),
    st.integers(1, 80),
    st.floats(-10.0, 10.0),
    st.floats(0.1, 20.0),
)
def test_prefilter_stays_within_its_bounds(
    w: float, m: float, half_period: int, low: float, width: float
) -> None:
    """Also where the reference jumps from end to end at its own frequency, which pumps it up."""
    resonance = max(1, round(math.pi / (w * math.sqrt(max(1.0 - m * m, 0.01)) * PERIOD)))
    for half in (half_period, resonance):
        reference = [low + width * float((k // half) % 2) for k in range(min(12 * half, 1000))]
        filtered, speed = _filtered(w, m, reference, start=low)
        least, most, top = bounds(low, low + width, w, m, PERIOD)
        rounding = 1e-12 * (abs(low) + width)
        assert least - rounding <= min(filtered) <= max(filtered) <= most + rounding
        assert np.max(np.abs(speed)) <= top + w * rounding


@given(st.floats(1.0, 1900.0), st.sampled_from([1, 2]), st.lists(numbers, min_size=1, max_size=40))
def test_velocity_is_a_low_pass_of_the_difference_by_tustin(
    bandwidth: float, order: int, positions: list[float]
) -> None:
    """order 1: w/(s + w). order 2: (5.70), 1/(s^2/w^2 + 2 s/w + 1), of the difference quotient."""

    def build(program: Program) -> ProgramNode:
        return velocity(
            program, input_of(program, "now") - input_of(program, "last"), PERIOD, bandwidth, order
        )

    differences = np.diff([0.0, *positions]) / PERIOD
    found = Block(build).run(now=positions, last=[0.0, *positions[:-1]])
    continuous = (
        ([bandwidth], [1.0, bandwidth])
        if order == 1
        else ([1.0], [1.0 / bandwidth**2, 2.0 / bandwidth, 1.0])
    )
    expected = signal.lfilter(*signal.bilinear(*continuous, 1 / PERIOD), differences)
    np.testing.assert_allclose(
        found, expected, rtol=1e-7, atol=1e-8 * max(1.0, float(np.max(np.abs(differences))))
    )


@given(st.lists(numbers, min_size=1, max_size=10), st.sampled_from([1, 2]))
def test_without_a_bandwidth_the_velocity_is_the_difference_itself(
    positions: list[float], order: int
) -> None:
    block = Block(
        lambda p: velocity(p, input_of(p, "now") - input_of(p, "last"), PERIOD, 0.0, order)
    )
    last = [0.0, *positions[:-1]]
    np.testing.assert_array_equal(
        block.run(now=positions, last=last), (np.array(positions) - last) * (1.0 / PERIOD)
    )


def _law(gain: float, band: float, error: float) -> float:
    return Block(
        lambda p: square_root_law(p, input_of(p, "error"), gain, p.constant(band, "band"))
    ).step(error=error)


@given(positive, positive, st.floats(0.0, 1e6))
def test_square_root_law_is_odd_and_stops_the_axis_by_friction_alone(
    gain: float, band: float, error: float
) -> None:
    law = _law(gain, band, error)
    assert _law(gain, band, -error) == -law
    if error > band:
        assert law == gain * math.sqrt(error)
        # with k = sqrt(2 F/J), the way that friction F/J = k^2/2 takes to stop from omega_c is the
        # error: (5.5)
        assert law**2 / gain**2 == pytest.approx(error, rel=1e-12)
    else:
        assert law == pytest.approx(gain * error / math.sqrt(band), rel=1e-12)
        assert law <= gain * math.sqrt(error) * (1 + 1e-12)


@given(positive, positive, numbers, st.floats(1e-9, 1e3))
def test_square_root_law_rises_and_nowhere_faster_than_at_the_band(
    gain: float, band: float, error: float, change: float
) -> None:
    step = _law(gain, band, error + change) - _law(gain, band, error)
    rounding = 1e-12 * gain * math.sqrt(abs(error) + change + band)
    assert -rounding <= step <= gain / math.sqrt(band) * change * (1 + 1e-6) + rounding


@given(positive, numbers)
def test_proportional_law_is_a_gain(gain: float, error: float) -> None:
    assert (
        Block(lambda p: proportional_law(p, input_of(p, "error"), gain)).step(error=error)
        == gain * error
    )


def _band(band: float, settled_speed: float | None, rest_speed: float, *, brakes: bool) -> Block:
    def build(program: Program) -> ProgramNode:
        moving = input_of(program, "filtered_speed")
        inside = is_settled(
            program,
            input_of(program, "error"),
            program.constant(band, "band"),
            moving,
            settled_speed,
        )
        return next_mode(
            program, inside, input_of(program, "speed") if brakes else None, rest_speed
        )

    return Block(build)


@given(
    st.sampled_from([RUN, BRAKE, REST]),
    st.booleans(),
    positive,
    st.none() | positive,
    positive,
    numbers,
    numbers,
    numbers,
)
def test_band_acts_inside_and_settled_only(
    mode: float,
    brakes: bool,
    band: float,
    settled_speed: float | None,
    rest: float,
    error: float,
    moving: float,
    speed: float,
) -> None:
    block = _band(band, settled_speed, rest, brakes=brakes).set(
        mode=mode, **({"speed": speed} if brakes else {})
    )
    new = block.step(error=error, filtered_speed=moving)
    inside = abs(error) <= band and (settled_speed is None or abs(moving) < settled_speed)
    assert (new == RUN) == (not inside)
    assert block.value("mode") == new
    if inside:
        assert new == (REST if not brakes or mode == REST or abs(speed) < rest else BRAKE)


def test_band_includes_its_edge_and_a_moving_prefilter_keeps_the_loop_closed() -> None:
    def mode(before: float, error: float, moving: float, speed: float | None = None) -> float:
        block = _band(2.0, 5.0, 40.0, brakes=speed is not None).set(mode=before)
        return block.step(
            error=error, filtered_speed=moving, **({} if speed is None else {"speed": speed})
        )

    assert mode(RUN, 2.0, 0.0) == REST
    assert mode(RUN, math.nextafter(2.0, 3.0), 0.0) == RUN
    assert mode(REST, 0.0, 5.0) == RUN
    assert mode(RUN, 0.0, 0.0, 40.0) == BRAKE
    assert mode(BRAKE, 0.0, 0.0, math.nextafter(40.0, 0.0)) == REST


@given(numbers, numbers, numbers, st.sampled_from([-1.0, 0.0, 1.0]), st.booleans())
def test_eta_is_the_integral_unless_it_pushes_into_the_limit(
    before: float, gone: float, motion: float, limited: float, rests: bool
) -> None:
    def build(program: Program) -> ProgramNode:
        resting = input_of(program, "resting") > program.constant(0.0)
        wanted, moved, met = (
            input_of(program, name) for name in ("increment", "motion", "limited")
        )
        return next_eta(program, wanted, moved, met, resting, 1e9)

    block = Block(build).set(eta_before=before)
    new = block.step(increment=gone, motion=motion, limited=limited, resting=float(rests))
    free = before + (gone - motion)
    if limited == 0.0:
        assert new == free
    else:
        assert new in (before, free)
        assert limited * (new - before) <= 0.0
        assert new == free or limited * (free - before) >= 0.0
    assert block.value("eta_before") == (0.0 if rests else new)


def _limit(bound: float, winding: tuple[float, float, float] | None = None) -> Block:
    def build(program: Program) -> ProgramNode:
        low, high = drive_limit.bounds(program, bound, winding, input_of(program, "speed"))
        program.named("lower", low + program.constant(0.0))
        program.named("upper", high + program.constant(0.0))
        return drive_limit.limit(program, input_of(program, "drive"), low, high)[0]

    return Block(build)


@given(st.floats(-1e9, 1e9), positive)
def test_limit_is_never_exceeded_and_says_which_one_it_met(drive: float, bound: float) -> None:
    block = _limit(bound)
    limited = block.step(drive=drive, speed=0.0)
    assert abs(limited) <= bound
    assert block.value("met") == (0.0 if limited == drive else math.copysign(1.0, drive))
    if abs(drive) <= bound:
        assert limited == drive


@given(
    st.floats(0.1, 100.0),
    st.floats(0.01, 5.0),
    st.floats(1e-3, 1.0),
    st.floats(1.0, 100.0),
    numbers,
    numbers,
)
def test_winding_leaves_what_the_back_emf_does(
    bound: float, resistance: float, constant: float, voltage: float, speed: float, drive: float
) -> None:
    """|R i + K v| <= V wherever the drive's own limit allows such a current at all; an axis run
    backwards faster is not driven further."""
    block = _limit(bound, (resistance, constant, voltage))
    current = block.step(drive=drive, speed=speed)
    assert -bound <= block.value("lower") <= current <= block.value("upper") <= bound
    if abs(constant * speed) <= voltage:
        assert (
            abs(resistance * current + constant * speed)
            <= voltage * (1 + 1e-9) + 1e-9 * resistance * bound
        )
    elif abs(constant * speed) - voltage < resistance * bound:
        assert current * speed < 0.0  # the supply cannot hold the back-EMF: what flows brakes
    if abs(drive) <= bound and abs(resistance * drive + constant * speed) < voltage * (1 - 1e-9):
        assert current == drive
