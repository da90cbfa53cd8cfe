"""Reversals and the slip mask: against slow references written from the definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.slip_mask import slip_mask
from frictool.identify.rows.smoothing import position_noise, smoothed
from frictool.identify.rows.strokes import Strokes, find_strokes, turning_points
from frictool.typing import Vector

PATHS = st.lists(st.integers(-4, 4), min_size=2, max_size=60)


def slow_turning_points(position: list[float], threshold: float) -> list[int]:
    """The last extreme before each retreat by more than the threshold, by looking back from every
    sample."""
    found: list[int] = []
    start, direction = 0, 0
    for k in range(len(position)):
        seen = position[start : k + 1]
        if direction >= 0 and max(seen) - position[k] > threshold:
            if direction > 0:
                found.append(start + max(i for i, x in enumerate(seen) if x == max(seen)))
            direction, start = -1, k
        elif direction <= 0 and position[k] - min(seen) > threshold:
            if direction < 0:
                found.append(start + max(i for i, x in enumerate(seen) if x == min(seen)))
            direction, start = 1, k
    return found


@settings(derandomize=True, deadline=None, max_examples=200)
@given(steps=PATHS, threshold=st.sampled_from([0.5, 1.5, 3.5]))
def test_turning_points_are_the_reversals(steps: list[int], threshold: float) -> None:
    position = np.cumsum(steps).astype(float)
    points = np.empty(position.size, dtype=np.int64)
    count = turning_points(position, threshold, points)
    assert points[:count].tolist() == slow_turning_points(position.tolist(), threshold)


def test_strokes_of_a_triangle() -> None:
    position = np.concatenate((np.arange(0, 50), np.arange(50, 10, -1), np.arange(10, 60))).astype(
        float
    )
    record = make_record(
        "triangle",
        np.arange(position.size) * 1e-3,
        position,
        np.zeros(position.size),
        resolution=1.0,
        lag=0.0,
    )
    strokes = find_strokes(record)
    assert strokes.number[[0, 50, 51, 90, 91, 139]].tolist() == [0, 0, 1, 1, 2, 2]
    assert strokes.sign[[10, 70, 120]].tolist() == [1.0, -1.0, 1.0]
    assert strokes.advance[60] == 10.0
    assert strokes.advance[100] == 10.0


def test_a_break_of_the_clock_ends_a_stroke() -> None:
    time = np.concatenate((np.arange(100), np.arange(150, 250))) * 1e-3
    record = make_record("gap", time, np.arange(200.0), np.zeros(200), resolution=1.0, lag=0.0)
    strokes = find_strokes(record)
    assert record.piece[[99, 100]].tolist() == [0, 1]
    assert strokes.number[99] != strokes.number[100]


def slow_speeds(record: MotionRecord, strokes: Strokes) -> Vector:
    """Mean speed over each motion by 1.5 counts (or as much noise), 0 where the axis may rest.

    It does not rest in the last count of a stroke if a constant deceleration explains the time.
    """
    distance = 1.5 * np.sqrt(12.0) * position_noise(record)
    speed = np.zeros(record.position.size)
    for number in np.unique(strokes.number):
        index = np.flatnonzero(strokes.number == number)
        x = record.position[index] * strokes.sign[index]
        parts = []
        first = 0
        while np.any(far := np.abs(x[first:] - x[first]) >= distance):
            parts.append((first, first + int(np.argmax(far))))
            first = parts[-1][1]
        parts.append((first, first + int(np.argmax(x[first:] == x[-1]))))
        for one, other in parts:
            if other > one:
                mean = (x[other] - x[one]) / ((other - one) * record.period)
                speed[index[one] : index[one] + other - one] = mean
        last = speed[index[parts[-1][1] - 1]] if parts[-1][1] > 0 else 0.0
        turning = index[parts[-1][1] :]
        if abs(last) * turning.size * record.period <= 4.0 * distance / 1.5:
            speed[turning] = last
        of_stroke = speed[index].copy()
        for k in range(index.size):
            least = min(np.max(of_stroke[: k + 1]), np.max(of_stroke[k:]))
            speed[index[k]] = 0.0 if of_stroke[k] < 0.1 * least else of_stroke[k]
    return speed


@settings(derandomize=True, deadline=None, max_examples=60)
@given(seed=st.integers(0, 1000), window=st.sampled_from([5, 11, 21]))
def test_mask_holds_for_every_sample_of_the_window(seed: int, window: int) -> None:
    generator = np.random.default_rng(seed)
    turns = np.cumsum(generator.uniform(20.0, 60.0, 8) * np.tile([1.0, -1.0], 4))
    position = np.round(np.interp(np.arange(400), np.linspace(0, 399, 8), turns))
    record = make_record(
        "zigzag", np.arange(400) * 1e-3, position, np.zeros(400), resolution=1.0, lag=0.0
    )
    strokes, velocity = find_strokes(record), np.gradient(position, 1e-3)
    backlash, reach = 4.0, (window - 1) // 2
    mask = slip_mask(record, strokes, velocity, window, backlash)
    slowest = max(2.0 / (window * 1e-3), 0.02 * np.max(velocity * strokes.sign))
    speed = slow_speeds(record, strokes)
    for k in range(400):
        around = range(k - reach, k + reach + 1)
        expected = around[0] >= 0 and around[-1] < 400
        expected = expected and all(
            strokes.number[j] == strokes.number[k]
            and min(velocity[j] * strokes.sign[j], speed[j]) > slowest
            and strokes.advance[j] > backlash + 2.0
            for j in around
        )
        assert mask[k] == expected


@pytest.mark.parametrize("window", [15, 61, 121])
@pytest.mark.parametrize("counts", [0.3, 2.0, 40.0])
def test_no_window_contains_a_rest(window: int, counts: float) -> None:
    """The axis rests at each reversal, and in the middle of each stroke.

    counts: speed in counts per sample.
    """
    draw = np.random.default_rng(window)
    pieces: list[Vector] = []
    for stroke in range(10):
        for _ in range(2):
            pieces.append(np.full(200, 1.0 - 2.0 * (stroke % 2)))
            pieces.append(np.zeros(draw.integers(80, 200)))
    velocity = np.concatenate(pieces)
    position = np.floor(counts * np.cumsum(velocity) + draw.random())
    time = np.arange(position.size) * 1e-3
    record = make_record("rests", time, position, np.zeros(time.size), resolution=1.0, lag=0.0)
    strokes = find_strokes(record)
    mask = slip_mask(record, strokes, smoothed(record, window)[1], window, 0.0)
    rest = np.convolve(velocity == 0.0, np.ones(window), mode="same") > 0.5
    assert np.count_nonzero(mask) > 0.5 * np.count_nonzero(~rest)
    assert not np.any(mask & rest)
