"""Zero-phase smoothing in which nothing is out of step with anything (4.2.2: filter every signal
alike).

The second derivative c of Savitzky and Golay (a cubic over W samples) annihilates straight lines,
so that it is the second difference of a bump g with sum 1. Convolving the equation of motion with g
gives, without any error of alignment,

    J (c * x) + viscous (g * dx) + coulomb (g * sign v) + offset = g * u_

    c * x     acceleration: the Savitzky-Golay filter itself
    dx        central difference (x[k+1] - x[k-1])/(2 T)
    u_        effort averaged over the triangle that a second difference of positions averages the
              acceleration with:
              no lag: held from its sample on    (u[k-1] + u[k])/2, exact
              a lag: measured at the instant, in between on its way to a held command like 1 -
              e^(-t/lag): weights of `effort_weights`, exact; (1, 4, 1)/6 where the lag is long

so that smoothing costs no bias whatever W is: J, viscous, coulomb and offset are those of the
unsmoothed equation. (Straight lines between the samples of a lagging current would put -0.07 % on
the clutch's inertia.)

Window (documented rule): the smallest odd W for which the noise that the position leaves on the
acceleration is at most a given share of the acceleration itself (rms), between 11 samples and a
sixth of the median stroke. The noise of the position is that of the encoder's quantisation,
step/sqrt(12), or what its fourth differences show, whichever is larger. A share s attenuates the
inertia by s^2; which share is small enough is for the regression to say (`least_squares`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs

from frictool.identify.motion_record import MotionRecord, Vector
from frictool.plant.weak_form import effort_weights
from frictool.runtime.kernels import kernel

Matrix = NDArray[np.float64]

DEGREE = 3
SHORTEST = 11  # samples
STROKE_SHARE = 1.0 / 6.0  # a window longer than this fraction of a stroke leaves too little of it
BLOCK = 1024  # samples that are filtered at a time
PLACES = 20_000  # at which the acceleration is looked at to choose a window
FOURTH_DIFFERENCE_GAIN = math.sqrt(70.0)  # rms of (1, -4, 6, -4, 1)


def acceleration_filter(window: int, period: float) -> Vector:
    """c (window,) in 1/s^2: the acceleration is its correlation with the position."""
    return np.asarray(
        savgol_coeffs(window, DEGREE, deriv=2, delta=period, use="dot"), dtype=np.float64
    )


def bump(window: int, period: float) -> Vector:
    """g (window - 2,), no unit, sum 1: the kernel whose second difference is c."""
    once = np.cumsum(acceleration_filter(window, period)) * period
    return np.asarray(np.cumsum(once[:-1])[:-1] * period, dtype=np.float64)


@kernel
def fourth_difference_power(position: Vector) -> float:
    """Mean square of the fourth differences of a position (n,), 0 where there is none."""
    total, count = 0.0, position.shape[0] - 4
    for k in range(count):
        middle = position[k + 2]
        difference = (
            (position[k] - middle)
            - 4.0 * (position[k + 1] - middle)
            - 4.0 * (position[k + 3] - middle)
            + (position[k + 4] - middle)
        )
        total += difference * difference
    return total / count if count > 0 else 0.0


def position_noise(record: MotionRecord) -> float:
    """Standard deviation of the position's noise, rad | m: of its quantisation, or of its fourth
    differences."""
    measured = math.sqrt(fourth_difference_power(record.position)) / FOURTH_DIFFERENCE_GAIN
    return max(record.resolution / math.sqrt(12.0), measured)


def measurement_noise(record: MotionRecord) -> float:
    """The same of what was measured: of the position, or of the velocity, rad/s | m/s."""
    if record.velocity is None:
        return position_noise(record)
    return max(
        record.count / math.sqrt(12.0),
        math.sqrt(fourth_difference_power(record.velocity)) / FOURTH_DIFFERENCE_GAIN,
    )


def acceleration_response(record: MotionRecord, window: int) -> Vector:
    """From what was measured to the acceleration (window,): c, or c on the integral of a measured
    velocity."""
    c = acceleration_filter(window, record.period)
    return (
        c if record.velocity is None else np.convolve(np.cumsum(c)[:-1] * record.period, (0.5, 0.5))
    )


def choose_window(record: MotionRecord, stroke_samples: float, share: float) -> int:
    """The window in samples, odd, by the rule above; `stroke_samples` is the median length of a
    stroke, `share` that of the noise."""
    longest = max(_odd(stroke_samples * STROKE_SHARE), SHORTEST)
    if record.position.size <= longest:
        return SHORTEST
    wanted = share * _rms_acceleration(record, longest)
    noise = measurement_noise(record)
    for window in range(SHORTEST, longest, 2):
        if noise * float(np.linalg.norm(acceleration_response(record, window))) <= wanted:
            return window
    return longest


def _rms_acceleration(record: MotionRecord, window: int) -> float:
    """rms of the acceleration smoothed over `window` samples, rad/s^2 | m/s^2, of some places of
    the record."""
    every = max(1, record.position.size // PLACES)
    windows = sliding_window_view(record.position, window)[::every]
    acceleration = (windows - windows[:, :1]) @ acceleration_filter(window, record.period)
    return float(np.sqrt(np.mean(acceleration**2)))


def _odd(length: float) -> int:
    return 2 * int(length / 2.0) + 1


@kernel
def filter_blocks(
    position: Vector, effort: Vector, c: Vector, g: Vector, held: Vector, period: float, out: Matrix
) -> None:
    """Fills `out` (3, n) of samples half a window from either end with c * position, g * central
    difference and g * mean effort.

    c (w,) and g (w - 2,) are symmetric; held (3,): what the samples before, at and after weigh in
    the mean effort. Block by block, each tap over all samples of its block: as many additions in
    the same order for every sample.
    """
    n, window = position.shape[0], c.shape[0]
    reach = (window - 1) // 2
    x, v, u = (
        np.empty(BLOCK + window - 1),
        np.empty(BLOCK + window - 3),
        np.empty(BLOCK + window - 3),
    )
    for first in range(reach, n - reach, BLOCK):
        rows = min(BLOCK, n - reach - first)
        origin = first - reach
        for k in range(rows + window - 1):
            x[k] = position[origin + k] - position[origin]
        for k in range(rows + window - 3):
            v[k] = (x[k + 2] - x[k]) / (2.0 * period)
            u[k] = (
                held[0] * effort[origin + k]
                + held[1] * effort[origin + k + 1]
                + held[2] * effort[origin + k + 2]
            )
        acceleration, velocity, mean = (
            out[0, first : first + rows],
            out[1, first : first + rows],
            out[2, first : first + rows],
        )
        out[:, first : first + rows] = 0.0
        for j in range(window):
            for k in range(rows):
                acceleration[k] += c[j] * x[k + j]
        for j in range(window - 2):
            for k in range(rows):
                velocity[k] += g[j] * v[k + j]
                mean[k] += g[j] * u[k + j]


def smoothed(record: MotionRecord, window: int) -> tuple[Vector, Vector, Vector]:
    """Acceleration, velocity and effort, each (n,), of one record in SI; nan within half a window
    of either end."""
    return smoothed_by(record, bump(window, record.period))


def smoothed_by(record: MotionRecord, g: Vector) -> tuple[Vector, Vector, Vector]:
    """The same with any symmetric kernel g (window - 2,), odd, of sum 1, whose second difference
    gives the acceleration."""
    window = g.size + 2
    out, n, reach = np.empty((3, record.position.size)), record.position.size, (window - 1) // 2
    out[:, :reach] = out[:, max(n - reach, 0) :] = np.nan
    if n <= window:
        out[:] = np.nan
    else:
        c = np.convolve(g, [1.0, -2.0, 1.0]) / record.period**2
        filter_blocks(
            record.position,
            record.effort,
            c,
            g,
            np.array(effort_weights(record.period, record.lag)),
            record.period,
            out,
        )
    return out[0], out[1], out[2]
