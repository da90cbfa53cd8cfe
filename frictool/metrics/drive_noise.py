"""White noise of a measured drive: its standard deviation and its peak.

A chattering loop also changes its drive from sample to sample. Its spectrum has lines, whereas
white noise has the same density at all frequencies. The smallest density of a signal's spectrum is
thus an upper bound of the density of the white noise on this signal.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from frictool.metrics.median import median
from frictool.typing import Vector

# distance of the noise floor from the expected maximum of n samples, in standard deviations; fewer
# than 1 of 1000 records exceed the noise floor by chance
MARGIN = 2.0
BY_CHANCE = 1e-3  # probability that a test rejects a record of white noise
LONGEST_BLOCK = 64  # samples of a block of the spectrum
FEWEST_BLOCKS = 8  # blocks of a spectrum; a record of fewer than 8 blocks of 8 samples has none
LEAKAGE = 2  # lowest line of the spectrum that a constant drive does not reach through the window


class WhiteNoise(NamedTuple):
    """White noise on a signal.

    - deviation: upper estimate of the noise's standard deviation, in the signal's unit
    - shown: True if the signal's changes from sample to sample have a white spectrum; False if they
      may be an oscillation of the drive
    """

    deviation: float
    shown: bool


def white_noise(signal: Vector) -> WhiteNoise:
    """Estimate the white noise on `signal` (n,); its standard deviation is 0 for n < 3.

    The first estimate is the median of |second difference|/(0.6745 sqrt 6). A component that is
    smooth from sample to sample does not change this estimate, but an oscillation or a coarse
    quantisation increases it. A second estimate comes from the smallest spectral density of the
    signal. The second estimate is used if it is significantly smaller.
    """
    if signal.size < 3:
        return WhiteNoise(0.0, True)
    first = signal[1:] - signal[:-1]
    deviation = median(np.abs(first[1:] - first[:-1])) / (0.6745 * math.sqrt(6.0))
    size = min(LONGEST_BLOCK, 2 ** int(math.log2(signal.size / FEWEST_BLOCKS)))
    if size < FEWEST_BLOCKS or deviation == 0.0:
        return WhiteNoise(deviation, True)
    scale = float(np.abs(signal).max())  # the square of a drive may be infinite
    powers = _powers(signal / scale, size)
    typical, least = _median_powers(signal.size // size, powers.size)
    smallest = float(powers.min())
    # the variance of the second differences, which a line at the Nyquist frequency increases most
    weights = np.sin(np.pi / size * np.arange(LEAKAGE, size // 2)) ** 4
    mean = float(np.sum(powers * weights) / (typical * np.sum(weights)))
    if smallest < least * (deviation / scale) ** 2:
        deviation = scale * math.sqrt(smallest / typical)
    return WhiteNoise(deviation, smallest >= least * mean)


def noise_deviation(signal: Vector) -> float:
    """Return the standard deviation of the white noise on `signal` (n,); 0 for n < 3."""
    return white_noise(signal).deviation


def noise_floor(signal: Vector) -> float:
    """Return the peak that the white noise on `signal` (n,) hardly ever exceeds.

    The peak, in the unit of the signal, is (sqrt(2 ln n) + 2) times the standard deviation of the
    noise.
    """
    return noise_deviation(signal) * peak_factor(signal.size)


def peak_factor(samples: int) -> float:
    """Return the peak of `samples` values of white noise, divided by their standard deviation.

    Fewer than 1 of 1000 records of white noise exceed this peak.
    """
    return math.sqrt(2.0 * math.log(max(samples, 2))) + MARGIN


@lru_cache(maxsize=16)
def ordered_noise(samples: int) -> Vector:
    """Return an upper bound of each |noise| of n samples, sorted, largest first, (n,).

    The bounds are multiples of the noise's standard deviation. The distribution of the noise is
    assumed to be unimodal, so that Gauss's inequality bounds the probability of a larger |noise|.
    The inequality of Dvoretzky, Kiefer and Wolfowitz bounds the difference between this probability
    and the observed frequency. The first bound is at most `peak_factor`.
    """
    chance = np.arange(1, samples + 1) / samples - math.sqrt(
        math.log(2.0 / BY_CHANCE) / (2.0 * samples)
    )
    chance = np.maximum(chance, 1.0 / samples)
    gauss = np.where(
        chance < 1.0 / 3.0, 2.0 / (3.0 * np.sqrt(chance)), math.sqrt(3.0) * (1.0 - chance)
    )
    bounds: Vector = np.minimum(gauss, peak_factor(samples))
    bounds.flags.writeable = False
    return bounds


def _powers(signal: Vector, size: int) -> Vector:
    """Return the power of each spectral line, as the median over blocks of `size` samples.

    The median over the blocks ignores steps of the drive. For white noise, each power is the
    variance times the median of an exponential distribution of mean 1.
    """
    blocks = signal[: signal.size // size * size].reshape(-1, size)
    window = np.sin(np.pi / size * np.arange(size)) ** 2
    lines = np.fft.rfft(blocks * window)[:, LEAKAGE : size // 2]
    powers = (lines.real**2 + lines.imag**2) / np.sum(window**2)
    middle = (len(powers) - 1) // 2
    return np.asarray(np.partition(powers, middle, axis=0)[middle])


@lru_cache(maxsize=16)
def _median_powers(blocks: int, lines: int) -> tuple[float, float]:
    """Return the typical and the least power that `_powers` gives for white noise of variance 1.

    With a probability of at least 1 - BY_CHANCE, all `lines` powers exceed the least power
    (Chernoff's bound).
    """
    rank = (blocks + 1) // 2
    half = rank / blocks
    surprise = math.log(lines / BY_CHANCE) / blocks
    low, high = 0.0, half
    for _ in range(60):
        share = 0.5 * (low + high)
        divergence = half * math.log(half / share) + (1.0 - half) * math.log(
            (1.0 - half) / (1.0 - share)
        )
        low, high = (share, high) if divergence > surprise else (low, share)
    return -math.log1p(-rank / (blocks + 1)), -math.log1p(-low)
