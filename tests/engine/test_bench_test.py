"""A bench test as the bench plays it: both players against a plain loop, and what holds whatever
the gains and the axis."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.bench_experiment import play_one_ramp, play_ramps, play_reference
from frictool.engine.bench_position_loop import PositionServo
from frictool.plant.axis import CONSTANT, DRIVE, DRIVE_LIMIT, LAG, POSITION, AxisParameters, rest
from frictool.typing import Vector
from studies.rigs.sample_logs import TRUTH

PERIOD, NO_LOAD = 1e-3, np.empty(0)


def plain_reference(
    axis: AxisParameters, servo: PositionServo, reference: Vector, start: float, delay: int
) -> tuple[Vector, Vector]:
    """The same loop word by word, each command in a list."""
    p, state, commands, measured, drive = axis.as_array(), rest(start), [0.0] * delay, [], []
    held = 0.0
    for k, wanted in enumerate(reference):
        measured.append(math.floor(state[POSITION] / axis.encoder_step) * axis.encoder_step)
        speed = (measured[k] - measured[max(k - 1, 0)]) / PERIOD
        held += servo.integral * (wanted - measured[k]) * PERIOD
        commands.append(
            (servo.proportional * (wanted - measured[k]) - servo.derivative * speed + held)
            / p[CONSTANT]
        )
        acting = float(np.clip(commands[k], -p[DRIVE_LIMIT], p[DRIVE_LIMIT]))
        drive.append(state[DRIVE] if p[LAG] > 0.0 else acting)
        assert advance(state, acting, p, PERIOD) == 0
    return np.array(measured), np.array(drive)


def played(
    axis: AxisParameters, servo: PositionServo, reference: Vector, start: float, delay: int
) -> tuple[Vector, Vector]:
    position, drive = np.empty(reference.size), np.empty(reference.size)
    p = axis.as_array()
    assert (
        play_reference(
            p, NO_LOAD, rest(start), np.array(servo), reference, PERIOD, delay, position, drive
        )
        == 0
    )
    return position, drive


@settings(max_examples=10, deadline=None)
@given(
    st.floats(1.0, 60.0),
    st.floats(0.01, 0.3),
    st.floats(0.0, 20.0),
    st.sampled_from([0.0, 0.003]),
    st.integers(0, 2),
    st.floats(5.0, 50.0),
)
def test_a_reference_is_followed_as_the_plain_loop_does(
    kp: float, kv: float, ki: float, lag: float, delay: int, start: float
) -> None:
    axis = TRUTH._replace(lag=lag)
    gains = TRUTH.constant * np.array([kp * kv, ki, kv])
    reference = 30.0 + 20.0 * np.sin(12.0 * np.arange(600) * PERIOD)
    position, drive = played(axis, PositionServo(*gains), reference, start, delay)
    expected = plain_reference(axis, PositionServo(*gains), reference, start, delay)
    np.testing.assert_array_equal(position, expected[0])
    np.testing.assert_allclose(drive, expected[1], rtol=0.0, atol=1e-12)
    assert np.abs(drive).max() <= axis.drive_limit


def segments(numbers: list[int], rise: int, rate: float) -> tuple[Vector, Vector]:
    one = rate * np.maximum(np.arange(rise) - 20, 0)
    return np.concatenate([np.sign(n) * one for n in numbers]), np.repeat(
        np.array(numbers, dtype=float), rise
    )


def next_change(values: Vector) -> NDArray[np.int64]:
    """At each row the first later one with another value, from the end backwards."""
    out = np.full(values.size, values.size)
    for k in range(values.size - 2, -1, -1):
        out[k] = out[k + 1] if values[k + 1] == values[k] else k + 1
    return out


def plain_ramps(
    axis: AxisParameters,
    rows: Vector,
    segment: Vector,
    advance_on: float,
    low: float,
    high: float,
    start: float,
) -> Vector:
    """The rule as `excite` prints it: row by row, in words."""
    p, state, k, out = axis.as_array(), rest(start), 0, []
    began = math.floor(state[POSITION] / axis.encoder_step) * axis.encoder_step
    while k < rows.size:
        x = math.floor(state[POSITION] / axis.encoder_step) * axis.encoder_step
        if k > 0 and segment[k] != segment[k - 1] and rows[k] == 0.0 and not out[-1][2]:
            began = x
        side, jumped = np.sign(segment[k]), False
        if (side > 0.0 and x > high) or (side < 0.0 and x < low):
            k, began, jumped = (
                next((j for j in range(k, rows.size) if np.sign(segment[j]) != side), rows.size),
                x,
                True,
            )
        elif abs(x - began) >= advance_on:
            k, began, jumped = (
                next((j for j in range(k, rows.size) if segment[j] != segment[k]), rows.size),
                x,
                True,
            )
        if k >= rows.size:
            break
        out.append((x, state[DRIVE], jumped))
        assert advance(state, rows[k], p, PERIOD) == 0
        k += 1
    return np.array([(x, i) for x, i, _ in out])


@settings(max_examples=6, deadline=None)
@given(st.floats(10.0, 20.0), st.floats(0.3, 3.0), st.floats(15.0, 40.0))
def test_ramps_are_played_by_their_rules(low: float, advance_on: float, rate: float) -> None:
    rows, segment = segments([*range(1, 8), *(-n for n in range(1, 12))], 900, rate * PERIOD)
    rules, jumps = (
        np.array([advance_on, low, low + 4.0]),
        (next_change(segment), next_change(np.sign(segment))),
    )
    position, drive, used = np.empty(rows.size), np.empty(rows.size), np.zeros(1, dtype=np.int64)
    start = low + 0.03
    p = TRUTH.as_array()
    assert (
        play_ramps(
            p, NO_LOAD, rest(start), rows, segment, *jumps, rules, PERIOD, 0, position, drive, used
        )
        == 0
    )
    n = int(used[0])
    expected = plain_ramps(TRUTH, rows, segment, advance_on, low, low + 4.0, start)
    assert n == expected.shape[0]
    np.testing.assert_array_equal(position[:n], expected[:, 0])
    np.testing.assert_allclose(drive[:n], expected[:, 1], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("lag", [0.0, 0.003])
def test_a_ramp_below_the_breakaway_moves_nothing_and_is_played_to_its_end(lag: float) -> None:
    axis = TRUTH._replace(lag=lag, offset=0.0, backlash=0.0)
    rows, segment = segments([1, -1], 300, 0.9 * axis.breakaway / axis.constant / 280.0)
    jumps, rules = (next_change(segment), next_change(np.sign(segment))), np.array([0.2, 3.0, 60.0])
    position, drive, used = np.empty(rows.size), np.empty(rows.size), np.zeros(1, dtype=np.int64)
    assert (
        play_ramps(
            axis.as_array(),
            NO_LOAD,
            rest(30.0),
            rows,
            segment,
            *jumps,
            rules,
            PERIOD,
            1,
            position,
            drive,
            used,
        )
        == 0
    )
    assert used[0] == rows.size
    assert np.ptp(position) == 0.0


def plain_ramp(
    axis: AxisParameters, direction: float, turn: float, advance_on: float, samples: int
) -> tuple[Vector, list[float]]:
    """Return the last state and all positions of a ramp of 10 A/s that begins after 10 samples."""
    p, state, positions = axis.as_array(), rest(0.0), [0.0]
    for k in range(samples):
        assert advance(state, direction * max(0, k - 9) * 10.0 * PERIOD, p, PERIOD) == 0
        positions.append(state[POSITION])
        is_over = direction * state[POSITION] > turn or abs(state[POSITION]) >= advance_on
        if is_over and advance_on < math.inf:
            break
    return state, positions


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize(("turn", "advance_on"), [(5.0, 0.5), (0.2, 0.5), (0.2, math.inf)])
def test_one_ramp_is_the_plain_loop(direction: float, turn: float, advance_on: float) -> None:
    axis, samples = TRUTH, 600
    wanted, positions = plain_ramp(axis, direction, turn, advance_on, samples)
    state, extremes = rest(0.0), np.zeros(3)
    ramp = (direction, 10.0, 100.0, 10, samples)
    is_beyond, status = play_one_ramp(
        axis.as_array(), state, *ramp, PERIOD, turn, advance_on, extremes
    )
    assert status == 0
    assert positions[-1] != 0.0
    assert (len(positions) <= samples) == (advance_on < math.inf)
    assert np.array_equal(state, wanted)
    assert is_beyond == (direction * positions[-1] > turn)
    assert extremes[:2].tolist() == [min(positions), max(positions)]
