"""Response time, overshoot, static error and oscillations against closed forms, and against a plain
slow form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.final_value import final_value
from frictool.metrics.oscillations import oscillations
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.response_time import response_time_95
from frictool.metrics.reversals import reversals, turning_points
from frictool.metrics.rise_time import rise_time
from frictool.metrics.static_error import static_error
from frictool.typing import Vector
from studies.rigs.step_responses import first_order, overshoot_of, second_order

TIME = np.arange(4000) * 1e-3


def test_response_time_of_a_first_order_lag_is_three_time_constants() -> None:
    position = 5.0 + 50.0 * first_order(TIME, 0.1)
    assert response_time_95(TIME, position, 5.0, 55.0) == pytest.approx(
        0.1 * math.log(20.0), abs=1.01e-3
    )


def test_rise_time_of_a_first_order_lag() -> None:
    position = 5.0 + 50.0 * first_order(TIME, 0.1)
    assert rise_time(TIME, position, 5.0, 55.0) == pytest.approx(0.1 * math.log(9.0), rel=1e-4)


def test_rise_time_is_of_the_way_that_the_axis_goes() -> None:
    """It stands 2 short of the old reference and stops 3 short of the new one: neither is on its
    way."""
    position = 8.0 + 44.0 * first_order(TIME, 0.1)
    assert rise_time(TIME, position, 10.0, 55.0) == pytest.approx(0.1 * math.log(9.0), rel=1e-4)


def test_rise_time_ends_with_the_first_passage() -> None:
    """Underdamped, it falls below 90 % again."""
    fine = np.arange(0.0, 4.0, 1e-6)
    response = second_order(fine, 0.1, 20.0)
    exact = fine[np.argmax(response >= 0.9)] - fine[np.argmax(response >= 0.1)]
    assert rise_time(TIME, second_order(TIME, 0.1, 20.0), 0.0, 1.0) == pytest.approx(
        exact, abs=1e-4
    )


@pytest.mark.parametrize("position", [np.zeros(4000), 0.49 * first_order(TIME, 0.1)])
def test_what_stops_short_of_half_of_the_step_has_no_rise_time(position: Vector) -> None:
    assert rise_time(TIME, position, 0.0, 1.0) == math.inf


def test_an_axis_that_stood_there_before_rises_in_no_time() -> None:
    flicker = 55.0 + 0.1 * (np.arange(4000) % 7 == 0)
    assert rise_time(TIME, flicker, 5.0, 55.0) == 0.0


def test_response_time_waits_for_the_last_swing() -> None:
    """At damping 0.3 the first undershoot still leaves the zone: the last crossing is solved on a
    fine grid."""
    fine = np.arange(0.0, 4.0, 1e-6)
    outside = np.flatnonzero(np.abs(second_order(fine, 0.3, 20.0) - 1.0) > 0.05)
    exact = fine[outside[-1]]
    assert exact > 0.4
    assert response_time_95(TIME, second_order(TIME, 0.3, 20.0), 0.0, 1.0) == pytest.approx(
        exact, abs=1.01e-3
    )


def test_response_is_around_the_final_value_and_not_the_reference() -> None:
    position = 0.9 * first_order(TIME, 0.1)
    zone = 0.05 / 0.9
    assert response_time_95(TIME, position, 0.0, 1.0) == pytest.approx(
        -0.1 * math.log(zone), abs=1.01e-3
    )


@pytest.mark.parametrize(
    "position",
    [
        pytest.param(np.zeros(4000), id="stalled"),
        pytest.param(0.49 * first_order(TIME, 0.1), id="half way"),
        pytest.param(1.0 + 0.1 * np.sin(20.0 * TIME), id="limit cycle"),
        pytest.param((TIME / TIME[-1]) ** 3, id="still moving"),
    ],
)
def test_what_does_not_settle_has_no_response_time(position: Vector) -> None:
    assert response_time_95(TIME, position, 0.0, 1.0) == math.inf


def test_zone_is_never_narrower_than_the_sensor() -> None:
    """A step of four counts: its 5 % are a fifth of a count, and the axis flickers between two
    counts for ever."""
    flicker = np.where(np.arange(4000) % 2 == 0, 4.0, 3.0)
    position = np.where(TIME < 0.2, 0.0, flicker)
    assert response_time_95(TIME, position, 0.0, 4.0, resolution=1.0) == pytest.approx(0.2)
    assert response_time_95(TIME, position, 0.0, 4.0) == math.inf


@pytest.mark.parametrize("damping", [0.2, 0.4, 0.6, 0.8])
@pytest.mark.parametrize(("origin", "target"), [(5.0, 55.0), (55.0, 5.0)])
def test_overshoot_of_a_second_order_response(damping: float, origin: float, target: float) -> None:
    position = origin + (target - origin) * second_order(TIME, damping, 30.0)
    assert overshoot_percent(position, origin, target) == pytest.approx(
        overshoot_of(damping), rel=1e-3
    )


def test_overshoot_is_beyond_the_reference_and_never_negative() -> None:
    assert overshoot_percent(0.9 * second_order(TIME, 0.8, 30.0), 0.0, 1.0) == 0.0


def test_overshoot_within_a_sensor_step_counts_as_none() -> None:
    position = np.concatenate((np.zeros(50), np.full(50, 56.0), np.full(50, 55.0)))
    assert overshoot_percent(position, 5.0, 55.0, resolution=1.0) == 0.0
    assert overshoot_percent(position, 5.0, 55.0, resolution=0.9) == pytest.approx(2.0)


@pytest.mark.parametrize("step", [0.1122, 1.9e-5, 2.0 * math.pi / 4106.0])
def test_whole_sensor_steps_at_a_limit_are_not_beyond_it_by_rounding(step: float) -> None:
    """An overshoot of one count, a return of two, and a zone of one, at any place of the axis."""
    for place in range(0, 40_000, 97):
        overshooting = step * (place + np.r_[0, 10, 21, np.full(40, 20)])
        assert overshoot_percent(overshooting, step * place, step * (place + 20), step) == 0.0
        swing = step * (place + np.r_[0, 10, 20, 22, 20, 22, np.full(40, 20)])
        assert reversals(swing, step * place, step * (place + 20), step) == 0
        late = step * (place + np.r_[0, 10, np.full(10, 21), np.full(400, 20)])
        time = 1e-3 * np.arange(late.size)
        assert response_time_95(time, late, step * place, step * (place + 20), step) == 2e-3


def test_static_error_counts_either_side() -> None:
    assert static_error(np.full(100, 53.5), 55.0) == pytest.approx(1.5)
    assert static_error(np.full(100, 56.5), 55.0) == pytest.approx(1.5)


def test_a_rest_some_counts_off_meets_a_limit_of_as_many_counts() -> None:
    """Positions and target are rounded multiples of the encoder's step."""
    draw = np.random.default_rng(12)
    for _ in range(500):
        step = float(f"{10.0 ** draw.uniform(-7.0, -2.0):.3g}")
        target, counts = int(draw.integers(-(10**6), 10**6)), int(draw.integers(1, 10))
        position = np.full(int(draw.integers(20, 3000)), (target + counts) * step)
        limit = counts * step
        assert static_error(position, target * step, step) <= limit
        assert static_error(position + 1e-3 * step, target * step, step) > limit
        assert static_error(position, target * step, step) == pytest.approx(limit, rel=1e-7)


def test_final_value_is_the_mean_of_the_last_tenth() -> None:
    assert final_value(
        np.concatenate((np.zeros(900), np.full(50, 1.0), np.full(50, 2.0)))
    ) == pytest.approx(1.5)
    assert final_value(np.arange(20.0)) == pytest.approx(14.5)
    assert final_value(np.array([3.0])) == 3.0


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        pytest.param([1.0], 0, id="no overshoot"),
        pytest.param([1.03, 1.025], 0, id="back by less than 1 %"),
        pytest.param([1.03, 1.0], 1, id="an overshoot and its return"),
        pytest.param([1.04, 0.98, 1.0], 1, id="an overshoot and an undershoot"),
        pytest.param([1.04, 0.96, 1.03, 1.0], 2, id="two overshoots"),
        pytest.param([1.04, 0.96, 1.03, 0.97, 1.0], 2, id="two of each"),
        pytest.param([1.04, 0.96, 1.03, 0.97, 1.02, 1.0], 3, id="three overshoots"),
    ],
)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_oscillations_of_drawn_responses(
    turns: list[float], expected: int, direction: float
) -> None:
    knots = [0.0, *turns, turns[-1]]
    times = [0.0, *(0.1 * (k + 1) for k in range(len(turns))), 4.0]
    position = direction * np.interp(TIME, times, knots)
    assert oscillations(position, 0.0, direction) == expected
    assert math.ceil(reversals(position, 0.0, direction) / 2) == expected
    assert reversals(position, 0.0, direction) == (0 if expected == 0 else len(turns) - 1)


def test_a_limit_cycle_has_many_oscillations() -> None:
    position = 1.0 + 0.1 * np.sin(2 * math.pi * 5.0 * TIME)
    assert 19 <= oscillations(position, 0.0, 1.0) <= 20


def test_turns_before_the_zone_do_not_count() -> None:
    position = np.interp(TIME, [0.0, 0.1, 0.2, 0.3, 4.0], [0.0, 0.6, 0.3, 1.0, 1.0])
    assert oscillations(position, 0.0, 1.0) == 0


def test_encoder_flicker_is_no_oscillation() -> None:
    flicker = np.where(np.arange(4000) // 50 % 2 == 0, 50.0, 49.0)
    assert oscillations(np.where(TIME < 0.1, 0.0, flicker), 0.0, 50.0, resolution=1.0) == 0


def plain_reversals(position: list[float], threshold: float) -> int:
    """Sample by sample: the running extreme, and a turn when the way back from it passes the
    threshold."""
    count, upward, extreme = 0, True, position[0]
    for value in position:
        if upward:
            extreme = max(extreme, value)
            turned = extreme - value > threshold
        else:
            extreme = min(extreme, value)
            turned = value - extreme > threshold
        if turned:
            count, upward, extreme = count + 1, not upward, value
    return count


@given(st.lists(st.integers(-30, 30), min_size=1, max_size=60), st.integers(0, 20))
def test_turning_points_equal_the_plain_form(values: list[int], threshold: int) -> None:
    position = np.array(values, dtype=float)
    found = turning_points(position, float(threshold), 1.0)
    assert len(found) == plain_reversals([float(v) for v in values], float(threshold))
    assert found == sorted(set(found))
    if len(found) > 1:  # neighbours are at least the threshold apart
        assert np.min(np.abs(np.diff(position[found]))) > threshold


@given(st.lists(st.integers(-30, 30), min_size=1, max_size=60), st.integers(0, 20))
def test_where_the_first_move_tells_the_direction_the_turns_are_those_of_that_direction(
    values: list[int], threshold: int
) -> None:
    position = np.array(values, dtype=float)
    found = turning_points(position, float(threshold))
    both = [turning_points(position, float(threshold), direction) for direction in (1.0, -1.0)]
    assert found == min(both, key=len) or np.ptp(position) <= threshold
    assert found == turning_points(-position, float(threshold))


@given(
    damping=st.floats(0.15, 0.9),
    frequency=st.floats(15.0, 60.0),
    scale=st.floats(1e-3, 1e3),
    offset=st.floats(-100.0, 100.0),
    shift=st.floats(-50.0, 50.0),
)
def test_metrics_do_not_depend_on_units_origin_or_clock(
    damping: float, frequency: float, scale: float, offset: float, shift: float
) -> None:
    position = second_order(TIME, damping, frequency)
    moved, origin, target = scale * (position + offset), scale * offset, scale * (1.0 + offset)
    response = response_time_95(TIME, position, 0.0, 1.0)
    assert response_time_95(TIME + shift, moved, origin, target) == pytest.approx(
        response, abs=1.01e-3
    )
    assert overshoot_percent(moved, origin, target) == pytest.approx(
        overshoot_percent(position, 0.0, 1.0), abs=1e-6
    )
    assert static_error(moved, target) == pytest.approx(
        scale * static_error(position, 1.0), abs=1e-9 * scale * (1.0 + abs(offset))
    )
    mirrored = oscillations(-moved, -origin, -target)
    assert mirrored == oscillations(moved, origin, target)


@pytest.mark.parametrize(("swing", "count"), [(1.5, 0), (2.5, 2), (30.0, 2)])
def test_a_reversal_returns_by_more_than_two_sensor_steps(swing: float, count: int) -> None:
    """The step of 100 sensor steps; 30 of them lie beyond the zone, in which turns count."""
    step = 0.5
    position = step * np.array([0.0, 50.0, 100.0, 100.0 - swing, 100.0, *[100.0] * 200])
    assert reversals(position, 0.0, 100.0 * step, step) == count


def test_an_axis_within_the_zone_responds_at_once_or_behind_the_last_sample_outside() -> None:
    time = 0.1 * np.arange(50)
    there = np.full(50, 2.0)
    assert response_time_95(time, there, 0.0, 2.0) == 0.0
    once = there.copy()
    once[7] = 1.8
    assert response_time_95(time, once, 0.0, 2.0) == pytest.approx(0.8)


def test_the_static_error_of_an_axis_that_moves_is_its_largest_error() -> None:
    """The mean of an oscillation about the target is 0, although the axis does not stay there."""
    time = np.arange(4000) * 1e-3
    step, amplitude = 1e-6, 7e-5
    moving = np.floor((1.0 + amplitude * np.sin(40.0 * time)) / step) * step
    assert static_error(moving, 1.0) < 0.2 * amplitude
    assert static_error(moving, 1.0, step) == pytest.approx(amplitude, rel=0.03)
    resting = 1.0 + step * np.resize([0.0, 1.0, 2.0], time.size)
    assert static_error(resting, 1.0, step) == static_error(resting, 1.0)
