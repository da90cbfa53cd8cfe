"""Flat tops, held values, quantisation and velocities of constructed signals, wherever their blocks
end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.logs.quality.quantisation import MOST, DistinctValues
from frictool.logs.quality.saturation import FlatTop, FlatTopDetector
from frictool.logs.quality.velocity_range import VelocityRange
from frictool.logs.quality.zero_order_hold import HoldDetector

CUTS = st.lists(st.integers(1, 3999), max_size=4, unique=True)
K = np.arange(4000)


def blocks(values: np.ndarray, cuts: list[int]) -> list[np.ndarray]:
    return np.split(values, sorted(cuts))


def quantised(values: np.ndarray, step: float | None) -> np.ndarray:
    return values if step is None else step * np.rint(values / step)


def tops(values: np.ndarray, step: float | None, cuts: list[int]) -> tuple[FlatTop, ...]:
    found = FlatTopDetector(float(values.min()), float(values.max()), step)
    for block in blocks(values, cuts):
        found.take(block)
    return found.result()


@given(
    step=st.sampled_from([None, 1e-4, 0.01, 0.05]),
    period=st.floats(20.0, 2000.0),
    phase=st.floats(0.0, 6.2),
    cuts=CUTS,
)
def test_a_sine_has_no_flat_top_however_it_is_quantised(
    step: float | None, period: float, phase: float, cuts: list[int]
):
    assert tops(quantised(np.sin(2 * np.pi * K / period + phase), step), step, cuts) == ()


@given(
    step=st.sampled_from([None, 1e-3, 0.01]),
    level=st.floats(0.2, 0.8),
    noise=st.sampled_from([0.0, 0.03]),
    seed=st.integers(0, 99),
    cuts=CUTS,
)
def test_a_clipped_sine_has_two(
    step: float | None, level: float, noise: float, seed: int, cuts: list[int]
):
    rng = np.random.default_rng(seed)
    sine = quantised(np.sin(K / 60.0) + rng.normal(0.0, noise, K.size), step)
    clipped = np.clip(sine, -level, level)
    low, high = tops(clipped, step, cuts)
    assert (low.at, high.at) == (-level, level)
    assert abs(low.samples - np.sum(sine <= -level)) <= 0.02 * K.size
    assert high.longest == longest_run(
        np.abs(clipped - level) < 0.5 * max(step or 0.0, 2e-3 * level)
    )


def longest_run(true: np.ndarray) -> int:
    run = longest = 0
    for one in true:
        run = run + 1 if one else 0
        longest = max(longest, run)
    return longest


def test_a_velocity_that_rests_at_zero_is_not_saturated():
    assert tops(np.maximum(0.0, np.sin(K / 300.0)), None, []) == ()
    assert [top.at for top in tops(np.maximum(0.1, np.sin(K / 300.0)), None, [])] == [0.1]


def test_a_signal_that_is_held_is_not_called_saturated():
    assert tops(np.repeat(np.sin(K[::20] / 60.0), 20), None, []) == ()
    assert tops(np.full(100, 3.0), None, []) == ()


@given(hold=st.integers(2, 40), step=st.sampled_from([None, 1e-3]), cuts=CUTS)
def test_a_held_signal_is_found_with_its_time(hold: int, step: float | None, cuts: list[int]):
    values = np.repeat(quantised(np.sin(K[: K.size // hold] * hold / 90.0 + 0.3), step), hold)
    held = HoldDetector()
    for block in np.split(values, sorted(cut for cut in cuts if cut < values.size)):
        held.take(block)
    assert held.samples(step) == hold


@given(speed=st.floats(0.001, 3.0), cuts=CUTS)
def test_an_encoder_that_counts_slowly_is_not_held(speed: float, cuts: list[int]):
    held = HoldDetector()
    for block in blocks(np.rint(300.0 * np.sin(K * speed / 300.0)), cuts):
        held.take(block)
    assert held.samples(1.0) is None


def test_a_continuous_signal_and_a_constant_are_not_held():
    for values in (np.sin(K / 50.0), np.zeros(100)):
        held = HoldDetector()
        held.take(values)
        assert held.samples(None) is None


@given(step=st.floats(1e-6, 10.0), seed=st.integers(0, 99), cuts=CUTS)
def test_quantisation_is_found_in_blocks(step: float, seed: int, cuts: list[int]):
    levels = DistinctValues()
    for block in blocks(step * np.random.default_rng(seed).integers(-40, 40, K.size), cuts):
        levels.take(block)
    assert levels.count == 80
    assert levels.step == pytest.approx(step, rel=1e-6)


def test_the_values_kept_are_bounded():
    levels, rng = DistinctValues(), np.random.default_rng(1)
    for _ in range(8):
        levels.take(rng.normal(size=MOST // 2))
    assert levels.count <= 2 * MOST
    assert levels.step is None


@given(step=st.sampled_from([None, 0.01, 0.1]), top=st.floats(5.0, 300.0), cuts=CUTS)
def test_velocities_are_those_of_the_motion_within_what_the_encoder_resolves(
    step: float | None, top: float, cuts: list[int]
):
    time = K / 1000.0
    omega = 2 * np.pi / 4.0
    position = quantised(top / omega * np.sin(omega * time), step)
    speed = VelocityRange(step)
    for part in np.split(K, sorted(cuts)):
        speed.take(time[part], position[part])
    assert speed.range is not None
    whole = VelocityRange(step)
    whole.take(time, position)
    assert (speed.range, speed.window) == (whole.range, whole.window)
    resolved = 2.0 * (step or 0.0) / (speed.window * 0.001) + 0.03 * top
    assert speed.range == (pytest.approx(-top, abs=resolved), pytest.approx(top, abs=resolved))


def test_two_samples_have_a_velocity_and_one_has_none():
    speed = VelocityRange(None)
    speed.take(np.array([0.0]), np.array([1.0]))
    assert speed.range is None
    speed.take(np.array([0.5]), np.array([2.0]))
    assert speed.range == (2.0, 2.0)
