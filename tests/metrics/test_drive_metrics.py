"""Noise, peak, rest and energy of the drive."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.metrics.drive_noise import noise_deviation, noise_floor, white_noise
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.metrics.drive_rms import drive_rms
from frictool.metrics.energy import energy
from frictool.metrics.rest_motion import late_samples, peak_to_peak
from frictool.metrics.saturation_time import commanded_saturation, measured_saturation

TIME = np.arange(5000) * 1e-3


def noise(
    seed: int, deviation: float, count: int = 5000
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return deviation * np.random.default_rng(seed).standard_normal(count)


@given(st.integers(0, 10**6), st.floats(1e-4, 10.0))
@settings(max_examples=30)
def test_noise_is_measured_beside_a_slow_drive(seed: int, deviation: float) -> None:
    slow = 20.0 * deviation * np.sin(2 * math.pi * 3.0 * TIME)
    assert noise_deviation(slow + noise(seed, deviation)) == pytest.approx(deviation, rel=0.08)


def test_noise_alone_stays_below_its_floor() -> None:
    peaks = [drive_peak(noise(seed, 0.05)) for seed in range(200)]
    assert max(peaks) == 0.0


def test_a_clean_drive_has_no_floor() -> None:
    held = np.where(TIME < 1.0, 50.0, 0.0)
    assert noise_floor(held) == 0.0
    assert drive_peak(held) == 50.0
    assert command_peak(-held) == 50.0


def test_a_saturated_noisy_drive_is_within_its_limit_and_an_excess_is_not() -> None:
    held = np.where(TIME < 0.1, 50.0, 0.0)
    assert 49.5 < drive_peak(held + noise(1, 0.05)) <= 50.0
    assert drive_peak(1.02 * held + noise(1, 0.05)) > 50.0


def test_a_slow_limit_cycle_is_seen_above_the_noise() -> None:
    assert drive_peak(2.5 * np.sin(2 * math.pi * TIME) + noise(2, 0.05)) > 2.0


CHATTER = {
    "sine of an eighth of the rate": np.sin(2 * math.pi * (0.124 * np.arange(5000) + 0.1)),
    "limited sine": np.clip(1.5 * np.sin(2 * math.pi * 0.31 * np.arange(5000)), -1.0, 1.0),
    "square wave of a quarter of the rate": np.sign(np.sin(math.pi / 2 * np.arange(5000) + 0.1)),
    "at the Nyquist frequency": (-1.0) ** np.arange(5000),
    "at random between two values": np.sign(noise(5, 1.0)),
}


@pytest.mark.parametrize("shape", CHATTER)
def test_a_chattering_drive_is_no_noise(shape: str) -> None:
    """The second differences alone took each of these for noise, with a peak of 0."""
    for measured in (8.0 * CHATTER[shape], 8.0 * CHATTER[shape] + noise(6, 0.05)):
        assert 7.2 < drive_peak(measured) <= 8.0
        assert white_noise(measured).shown == ("random" in shape)


@pytest.mark.parametrize("samples", [64, 200, 1000, 5000])
def test_white_noise_is_taken_for_white(samples: int) -> None:
    found = [white_noise(noise(seed, 2.0, samples)) for seed in range(200)]
    assert sum(not one.shown for one in found) <= 3
    rounded = [white_noise(np.round(noise(seed, 0.7, samples))) for seed in range(50)]
    assert sum(not one.shown for one in rounded) <= 3


@given(st.integers(0, 10**6), st.sampled_from([64, 500, 5000]))
@settings(max_examples=20)
def test_strong_noise_does_not_hide_a_constant_drive(seed: int, samples: int) -> None:
    """The peak of the noise is 6 A; most samples show that the drive is 8 A."""
    assert 6.0 < drive_peak(8.0 + noise(seed, 1.0, samples)) <= 8.0


def test_energy_is_the_mean_square_over_the_window() -> None:
    """Exact: i = 3 for 0.1 s, then 1: (9 * 0.1 + 1 * 0.18)/0.28."""
    drive = np.where(TIME < 0.1 - 1e-9, 3.0, 1.0)
    assert energy(TIME, drive, 0.28) == pytest.approx((0.9 + 0.18) / 0.28, rel=1e-9)


def test_energy_does_not_depend_on_an_even_rate() -> None:
    uneven = np.sort(np.concatenate((TIME, TIME[:100] + 0.4e-3)))
    drive = np.where(uneven < 0.1 - 1e-9, 3.0, 1.0)
    assert energy(uneven, drive, 0.28) == pytest.approx((0.9 + 0.18) / 0.28, rel=1e-9)


def test_energy_of_a_hold_shorter_than_the_window_is_not_known() -> None:
    assert (
        energy(TIME[:200], np.ones(200), 0.28)
        == "the reference is held for less than the window of 0.28 s"
    )
    assert energy(TIME[:280], np.ones(280), 0.28) == pytest.approx(1.0)


def test_remainder_begins_behind_the_time_asked() -> None:
    part = late_samples(TIME + 7.0, 4.0)
    assert part is not None
    assert TIME[part][0] == pytest.approx(4.0)
    assert late_samples(TIME, 4.995) is None
    assert peak_to_peak(np.array([1.0, 1.5, 0.5])) == 1.0


def test_rms_is_the_square_root_of_the_mean_square() -> None:
    """Exact: 3 for 1 s, -1 for 4 s."""
    assert drive_rms(TIME, np.where(TIME < 1.0 - 1e-9, 3.0, -1.0)) == pytest.approx(
        math.sqrt((9.0 + 4.0) / 5.0), rel=1e-12
    )
    assert drive_rms(TIME, 2.0 * np.sin(2 * math.pi * TIME)) == pytest.approx(
        math.sqrt(2.0), rel=1e-9
    )


def test_rms_does_not_depend_on_an_even_rate() -> None:
    uneven = np.sort(np.concatenate((TIME, TIME[:1000] + 0.4e-3)))
    drive = np.where(uneven < 1.0 - 1e-9, 3.0, -1.0)
    assert drive_rms(uneven, drive) == pytest.approx(math.sqrt((9.0 + 4.0) / 5.0), rel=1e-9)
    assert drive_rms(np.array([2.0]), np.array([-3.0])) == 3.0


def test_rms_and_energy_over_the_same_time_are_one_quantity() -> None:
    drive = noise(11, 3.0)
    assert drive_rms(TIME[:280], drive[:280]) ** 2 == pytest.approx(
        energy(TIME, drive, 0.28), rel=1e-12
    )


def test_saturation_counts_the_time_at_the_limit_on_either_side() -> None:
    command = np.select([TIME < 0.1 - 1e-9, TIME < 0.15 - 1e-9], [50.0, -50.0], 49.9)
    assert commanded_saturation(TIME, command, 50.0) == pytest.approx(0.15, rel=1e-9)
    assert commanded_saturation(TIME, command, 60.0) == 0.0
    in_16_bits = (
        np.round(command / 50.0 * 32767) / 32768 * 50.0
    )  # the largest number of a target's fixed point is below 1
    assert commanded_saturation(TIME, in_16_bits, 50.0) == pytest.approx(0.15, rel=1e-9)


@given(st.integers(0, 10**6), st.floats(0.01, 1.0))
@settings(max_examples=20)
def test_a_measured_drive_at_its_limit_is_found_beside_its_noise(
    seed: int, deviation: float
) -> None:
    drive = np.where(TIME < 0.5 - 1e-9, 50.0, 20.0) + noise(seed, deviation)
    assert measured_saturation(TIME, drive, 50.0, deviation) == pytest.approx(0.5, rel=0.06)


def test_half_a_sample_is_tolerated_at_the_end_of_the_window_of_energy() -> None:
    """Four samples of 1/4 s hold for 1 s; a window of 1.125 s ends half a sample behind it."""
    time = 0.25 * np.arange(4)
    drive = np.array([1.0, 2.0, 0.0, -2.0])
    assert energy(time, drive, 1.125) == pytest.approx(9.0 / 4.0)
    assert isinstance(energy(time, drive, 1.1251), str)
