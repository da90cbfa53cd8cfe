"""Limit cycles: sustained, ended, too slow for the hold; nothing where the axis flickers or is
noisy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.metrics.limit_cycle import LEAST_HOLD, limit_cycle
from frictool.metrics.reversals import turning_points
from frictool.typing import Vector
from studies.rigs.step_responses import second_order

PERIOD = 1e-3


def clock(held: float) -> Vector:
    return np.arange(round(held / PERIOD)) * PERIOD


def hunting(time: Vector, amplitude: float, period: float, phase: float = 0.3) -> Vector:
    """Stuck on one side of the reference, then on the other: what an integral and a breakaway make
    (5.2.1)."""
    return amplitude * np.sign(np.sin(2 * math.pi * (time / period + phase)))


@given(
    st.floats(0.01, 10.0),
    st.floats(0.05, 6.0),
    st.floats(0.0, 1.0),
    st.sampled_from(["sine", "hunting"]),
)
def test_amplitude_and_period_of_a_sustained_oscillation(
    amplitude: float, period: float, phase: float, shape: str
) -> None:
    time = clock(20.0)
    sine = amplitude * np.sin(2 * math.pi * (time / period + phase))
    found = limit_cycle(
        time, 15.0 + (sine if shape == "sine" else hunting(time, amplitude, period, phase))
    )
    assert found.amplitude == pytest.approx(amplitude, rel=2e-3)
    assert found.period == pytest.approx(period, abs=2.01 * PERIOD)


def test_an_axis_that_rests_has_none_behind_a_hold_of_15_s() -> None:
    time = 3.3 + clock(LEAST_HOLD)
    assert time.size == round(LEAST_HOLD / PERIOD)  # as a scenario's hold_s: 15 plays it
    assert limit_cycle(time, second_order(time, 0.5, 20.0)).amplitude == 0.0


def test_a_shorter_hold_cannot_tell() -> None:
    time = clock(LEAST_HOLD - 0.1)
    found = limit_cycle(time, second_order(time, 0.5, 20.0))
    assert (found.amplitude, found.period) == (None, None)
    assert "held for 14.9 s only" in found.reason


def test_an_obvious_cycle_is_told_in_a_short_hold() -> None:
    time = clock(2.0)
    found = limit_cycle(time, 0.2 * np.sin(2 * math.pi * 5.0 * time))
    assert found.amplitude == pytest.approx(0.2, rel=1e-3)
    assert found.period == pytest.approx(0.2, rel=1e-2)


def test_a_ringing_answer_in_a_short_hold_is_no_cycle() -> None:
    time = clock(2.0)
    assert limit_cycle(time, second_order(time, 0.05, 60.0)).amplitude is None


def test_an_oscillation_that_dies_out_is_no_cycle_once_it_has() -> None:
    time = clock(30.0)
    position = np.round(np.exp(-time / 5.0) * np.sin(2 * math.pi * time) / 0.05) * 0.05
    assert limit_cycle(time, position, 0.05).amplitude == 0.0


def test_an_oscillation_that_still_dies_out_is_undecided() -> None:
    time = clock(20.0)
    found = limit_cycle(time, np.exp(-time / 12.0) * np.sin(2 * math.pi * 0.5 * time), 0.01)
    assert found.amplitude is None
    assert "swings less and less" in found.reason


def test_a_cycle_slower_than_the_hold_is_not_told_absent() -> None:
    """36 s of period, as the PID of table 5.1: 20 s show one jump."""
    time = clock(20.0)
    found = limit_cycle(time, hunting(time, 0.084, 36.0, phase=0.05))
    assert found.amplitude is None
    assert "reverses at most once" in found.reason
    time = clock(120.0)
    found = limit_cycle(time, hunting(time, 0.084, 36.0, phase=0.05))
    assert (found.amplitude, found.period) == (pytest.approx(0.084), pytest.approx(36.0, abs=0.01))


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_flicker_between_two_counts_and_noise_are_no_motion(seed: int) -> None:
    time = clock(16.0)
    draw = np.random.default_rng(seed)
    assert limit_cycle(time, np.where(draw.random(time.size) < 0.5, 3.0, 3.1), 0.1).amplitude == 0.0
    assert limit_cycle(time, 3.0 + 0.01 * draw.standard_normal(time.size)).amplitude == 0.0


def test_a_cycle_of_eight_samples_is_no_noise() -> None:
    time = clock(16.0)
    noise = 0.01 * np.random.default_rng(4).standard_normal(time.size)
    found = limit_cycle(time, np.sin(2 * math.pi * 124.0 * time) + noise)
    assert found.amplitude == pytest.approx(1.0, abs=0.05)
    assert found.period == pytest.approx(1.0 / 124.0, rel=1e-3)


def test_a_cycle_beside_noise_keeps_its_period() -> None:
    time = clock(20.0)
    noise = 0.01 * np.random.default_rng(3).standard_normal(time.size)
    found = limit_cycle(time, hunting(time, 0.5, 3.0) + noise)
    assert found.amplitude == pytest.approx(0.5, abs=0.05)
    assert found.period == pytest.approx(3.0, rel=0.02)


def test_a_single_move_late_in_the_hold_is_undecided() -> None:
    time = clock(20.0)
    assert limit_cycle(time, np.where(time > 12.0, 1.0, 0.0)).amplitude is None


def test_a_cycle_that_has_stopped_is_absent_only_after_a_wait() -> None:
    time = clock(30.0)
    stopped = np.where(time < 14.0, hunting(time, 0.5, 2.0), 0.5)
    assert limit_cycle(time, stopped).amplitude == 0.0
    late = np.where(time < 28.0, hunting(time, 0.5, 4.0), 0.5)
    assert limit_cycle(time, late).amplitude == pytest.approx(0.5)


@pytest.mark.parametrize("phase", [0.1, 0.2])
def test_two_turns_in_a_long_hold_are_a_slow_cycle(phase: float) -> None:
    time = clock(24.0)
    found = limit_cycle(time, 3.0 * np.sin(2.0 * math.pi * (time / 12.0 + phase)))
    assert found.amplitude == pytest.approx(3.0, rel=1e-6)
    assert found.period == pytest.approx(12.0, abs=2.01 * PERIOD)


@pytest.mark.parametrize(("frequency", "turns"), [(1.25, 4), (1.5, 6)])
def test_three_periods_show_a_cycle_in_a_short_hold(frequency: float, turns: int) -> None:
    time = clock(3.0)
    position = np.sin(2.0 * math.pi * frequency * time)
    assert len(turning_points(position[1000:], 1e-6)) == turns  # behind the first third
    found = limit_cycle(time, position)
    if turns < 6:
        assert found.amplitude is None
        assert found.reason.startswith("the reference is held for 3 s only")
    else:
        assert found.amplitude == pytest.approx(1.0, rel=1e-4)
        assert found.period == pytest.approx(1.0 / frequency, abs=2.01 * PERIOD)


@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_an_axis_that_turned_twice_has_ended_if_it_rests_behind(drift: float) -> None:
    """It turns at 12 s and 13 s, and drifts in the second half of a hold of 30 s, or does not."""
    time = clock(30.0)
    levels = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0 + drift]
    found = limit_cycle(time, np.interp(time, [0.0, 11.0, 12.0, 13.0, 15.0, 30.0], levels))
    if drift == 0.0:
        assert found.amplitude == 0.0
    else:
        assert found.amplitude is None
        assert "moves by 1.3 after the first 10 s of the hold and swings less and less" in (
            found.reason
        )
