"""Periodogram of a residual over the position, on a grid of wave numbers.

The residuals r at the positions x are summed in bins of the position. An FFT of the bins gives the
amplitude 2 |sum r exp(-i n x)|/m for each wave number n; m is the number of samples. The amplitude
is computed for each half of the strokes. The smaller of the two amplitudes is used, so that a peak
must occur in both halves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.typing import IntVector, Vector

LEAST_PERIODS = 1.5  # periods within the travel; fewer look like a spring
BINS_PER_PERIOD = 6  # number of position bins in the shortest period
OVERSAMPLING = 16  # number of grid points of the wave number per 2 pi/travel
MOST_BINS = 1 << 15
# a peak is rounded to a whole number of cycles per turn if the difference is at most SNAP times the
# resolution and at most FARTHEST cycles
SNAP, FARTHEST = (0.35, 0.35)


@dataclass(frozen=True)
class SpectrumPeak:
    """Peak of a spectrum over the position.

    - number: wave number n, 1/rad | 1/m
    - amplitude: amplitude of the residual at n, N m | N
    - resolution: 2 pi/travel, the smallest separable difference of wave numbers, 1/rad | 1/m
    - tried: number of separable wave numbers in the searched range
    """

    number: float
    amplitude: float
    resolution: float
    tried: int


def highest_peak(
    position: Vector,
    residual: Vector,
    half: IntVector,
    shortest: float,
    excluded: tuple[float, ...] = (),
) -> SpectrumPeak | None:
    """Return the highest peak in the spectrum of the residual over the position.

    Parameters
    ----------
    position, residual
        Position (n,) [rad | m] and residual effort (n,) [N m | N].
    half
        Half of the strokes to which each sample belongs, 0 or 1, (n,).
    shortest
        Shortest period that is searched [rad | m].
    excluded
        Wave numbers [1/rad | 1/m] at and near which a peak is ignored.

    Returns
    -------
    SpectrumPeak or None
        None if the travel is shorter than LEAST_PERIODS times `shortest`, if a half is empty, or if
        all wave numbers are excluded.
    """
    low = float(position.min())
    travel = float(np.ptp(position))
    if travel <= LEAST_PERIODS * shortest or min(np.bincount(half, minlength=2)) == 0:
        return None
    bins = min(int(BINS_PER_PERIOD * travel / shortest), MOST_BINS)
    index = np.minimum((bins * (position - low) / travel).astype(np.int64), bins - 1)
    size = OVERSAMPLING * bins
    amplitude = np.min(
        [
            2.0
            * np.abs(
                np.fft.rfft(np.bincount(index[half == side], residual[half == side], bins), size)
            )
            / np.count_nonzero(half == side)
            for side in (0, 1)
        ],
        axis=0,
    )
    resolution = 2.0 * np.pi / travel
    number = np.arange(amplitude.size) * resolution / OVERSAMPLING
    allowed = (number >= LEAST_PERIODS * resolution) & (number <= 2.0 * np.pi / shortest)
    for one in excluded:
        allowed &= np.abs(number - one) > 0.75 * resolution
    if not allowed.any():
        return None
    best = int(np.argmax(np.where(allowed, amplitude, 0.0)))
    tried = max(1, int(np.count_nonzero(allowed) / OVERSAMPLING))
    return SpectrumPeak(float(number[best]), float(amplitude[best]), resolution, tried)


def snapped(peak: SpectrumPeak) -> float:
    """Return the wave number [1/rad] of a peak on a rotary axis, rounded if nearly whole."""
    nearest = float(round(peak.number))
    near = abs(nearest - peak.number) <= min(SNAP * peak.resolution, FARTHEST)
    return nearest if near and nearest >= 1.0 else peak.number
