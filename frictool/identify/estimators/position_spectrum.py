"""Periodogram of a residual over the position, on a grid of wave numbers.

The residuals r at the positions x are summed in bins of the position. An FFT of the bins gives the
amplitude 2 |sum r exp(-i n x)|/m for each wave number n; m is the number of samples. The amplitude
is computed for each half of the strokes. The smaller of the two amplitudes is used, so that a peak
must occur in both halves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.typing import IntVector, Matrix, Vector

LEAST_PERIODS = 1.5  # least number of periods within the travel; fewer periods look like a spring
# least and largest number of periods within the travel that `best_whole_number` tries
FEWEST_PERIODS, MOST_PERIODS = (0.75, 3.0)
BINS_PER_PERIOD = 6  # number of position bins in the shortest period
OVERSAMPLING = 16  # number of grid points of the wave number per 2 pi/travel
MOST_BINS = 1 << 15
MOST_WHOLE = 100  # largest number of cycles per turn in `best_whole_number`
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
        None if the travel is shorter than LEAST_PERIODS times `shortest`, if a half has no samples,
        or if all wave numbers are excluded.
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


def best_whole_number(
    position: Vector, regressors: Matrix, residual: Vector, excluded: tuple[float, ...] = ()
) -> SpectrumPeak | None:
    """Return the ripple with a whole number of cycles per turn that reduces the residual most.

    Numbers from 2 on are tried if the travel contains FEWEST_PERIODS to MOST_PERIODS periods. The
    fit is repeated with a sine and a cosine of each number.

    Parameters
    ----------
    position, residual
        Position (n,) [rad] and residual effort (n,) [N m].
    regressors
        Regressors (n, p) of the fit.
    excluded
        Wave numbers [1/rad] that are not tried.

    Returns
    -------
    SpectrumPeak or None
        None if no number is tried, or if every ripple is a combination of the regressors.
    """
    travel = float(np.ptp(position))
    resolution = 2.0 * np.pi / travel if travel > 0.0 else np.inf
    numbers = [
        number
        for number in range(2, int(min(MOST_PERIODS * resolution, MOST_WHOLE)) + 1)
        if number >= FEWEST_PERIODS * resolution and not np.any(np.isclose(number, excluded))
    ]
    fitted = np.linalg.qr(regressors)[0]
    left = np.inf
    best: SpectrumPeak | None = None
    for number in numbers:
        waves = np.column_stack((np.sin(number * position), np.cos(number * position)))
        free = waves - fitted @ (fitted.T @ waves)
        value, squares = np.linalg.lstsq(free, residual, rcond=None)[:2]
        if squares.size and squares[0] < left:
            left = float(squares[0])
            amplitude = float(np.linalg.norm(value))
            best = SpectrumPeak(float(number), amplitude, resolution, len(numbers))
    return best


def rounded_wave_number(peak: SpectrumPeak) -> float:
    """Return the wave number [1/rad] of a peak; if it is nearly an integer, return this integer."""
    nearest = float(round(peak.number))
    near = abs(nearest - peak.number) <= min(SNAP * peak.resolution, FARTHEST)
    return nearest if near and nearest >= 1.0 else peak.number
