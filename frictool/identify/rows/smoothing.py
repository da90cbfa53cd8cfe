"""Zero-phase smoothing with the same kernel for acceleration, velocity and effort.

The Savitzky-Golay filter c for the second derivative (a cubic over W samples) is the second
difference of a kernel g with sum 1. The convolution * of the equation of motion with g gives

    J (c * x) + viscous (g * dx) + coulomb (g * sign v) + offset = g * u_

with the inertia J and the other parameters of the unsmoothed equation, for any W. x is the
position, v the velocity, u the effort, and T the sample period.

- c * x: acceleration by the Savitzky-Golay filter
- dx: central difference (x[k+1] - x[k-1])/(2 T)
- u_: mean effort over the time of the second difference (`effort_weights`). For a held effort, this
  mean is (u[k-1] + u[k])/2; for an effort after a long lag, about (u[k-1] + 4 u[k] + u[k+1])/6.

The window W is the smallest odd number of samples with which the noise of the position causes at
most the fraction s of the rms acceleration. W is between 11 samples and a sixth of the median
stroke. The noise of the position is the larger of the quantisation noise, step/sqrt(12), and an
estimate from fourth differences. This noise decreases the fitted inertia by the fraction s^2;
`slip_fit` chooses s.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from frictool.identify.motion_record import MotionRecord, once_per_record
from frictool.identify.rows.savitzky_golay import savitzky_golay
from frictool.plant.weak_form import effort_weights
from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector

DEGREE = 3
SHORTEST = 11  # samples, shortest window
STROKE_SHARE = 1.0 / 6.0  # longest window relative to a stroke, so that enough samples are left
BLOCK = 1024  # samples filtered at a time
ROWS = 256  # windows multiplied at a time, so that they stay in the processor's cache
# largest number of samples at which the acceleration is evaluated to choose a window
GRID_POINTS = 20_000
FOURTH_DIFFERENCE_GAIN = math.sqrt(70.0)  # root of the sum of squares of (1, -4, 6, -4, 1)


def acceleration_filter(window: int, period: float) -> Vector:
    """Return the Savitzky-Golay filter c (window,), 1/s^2, from position to acceleration."""
    return savitzky_golay(window, DEGREE, 2, period)


def smoothing_kernel(window: int, period: float) -> Vector:
    """Return the smoothing kernel g (window - 2,) of sum 1, defined in the module docstring."""
    once = np.cumsum(acceleration_filter(window, period)) * period
    return np.asarray(np.cumsum(once[:-1])[:-1] * period, dtype=np.float64)


@kernel
def fourth_difference_power(position: Vector) -> float:
    """Return the mean square of the fourth differences of a position (n,); 0 if n < 5."""
    total = 0.0
    count = position.shape[0] - 4
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
    """Return the standard deviation of the position noise, rad | m.

    The result is the larger of the quantisation noise and an estimate from fourth differences.
    """
    measured = math.sqrt(fourth_difference_power(record.position)) / FOURTH_DIFFERENCE_GAIN
    return max(record.resolution / math.sqrt(12.0), measured)


def measurement_noise(record: MotionRecord) -> float:
    """Return the rms noise of the measured signal.

    The signal is the velocity [rad/s | m/s] if it was measured, else the position [rad | m].
    """
    if record.velocity is None:
        return position_noise(record)
    return max(
        record.count / math.sqrt(12.0),
        math.sqrt(fourth_difference_power(record.velocity)) / FOURTH_DIFFERENCE_GAIN,
    )


def white_noise(signal: Vector) -> float:
    """Return the standard deviation of the white noise in a signal (n,), from second differences.

    The median makes the result robust against steps of the signal.
    """
    if signal.size <= 2:
        return 0.0
    return float(np.median(np.abs(np.diff(signal, 2)))) / (0.6745 * math.sqrt(6.0))


def acceleration_response(record: MotionRecord, window: int) -> Vector:
    """Return the impulse response (window,) from the measured signal to the acceleration.

    The signal is the velocity (response in 1/s) if it was measured, else the position (1/s^2).
    """
    return _response(window, record.period, record.velocity is not None)


def _response(window: int, period: float, of_velocity: bool) -> Vector:
    c = acceleration_filter(window, period)
    return np.convolve(np.cumsum(c)[:-1] * period, (0.5, 0.5)) if of_velocity else c


@functools.cache
def _noise_gain(window: int, period: float, of_velocity: bool) -> float:
    """Return the rms acceleration caused by white noise of rms 1 in position or velocity."""
    return float(np.linalg.norm(_response(window, period, of_velocity)))


def choose_window(record: MotionRecord, stroke_samples: float, share: float) -> int:
    """Return the shortest smoothing window [samples] that suppresses noise sufficiently.

    With this window, noise causes at most the fraction `share` of the rms acceleration. The window
    is between SHORTEST and a sixth of `stroke_samples`, the median length of a stroke.
    """
    longest = max(_odd(stroke_samples * STROKE_SHARE), SHORTEST)
    if record.position.size <= longest:
        return SHORTEST
    wanted = share * _rms_acceleration(record, longest)
    noise = measurement_noise(record)
    for window in range(SHORTEST, longest, 2):
        if noise * _noise_gain(window, record.period, record.velocity is not None) <= wanted:
            return window
    return longest


@once_per_record
def _rms_acceleration(record: MotionRecord, window: int) -> float:
    every = max(1, record.position.size // GRID_POINTS)
    windows = sliding_window_view(record.position, window)[::every]
    c = acceleration_filter(window, record.period)
    acceleration = np.empty(windows.shape[0])
    for first in range(0, windows.shape[0], ROWS):
        rows = windows[first : first + ROWS]
        acceleration[first : first + ROWS] = (rows - rows[:, :1]) @ c
    return float(np.sqrt(np.mean(acceleration**2)))


def _odd(length: float) -> int:
    return 2 * int(length / 2.0) + 1


@kernel
def filter_blocks(
    position: Vector, effort: Vector, c: Vector, g: Vector, held: Vector, period: float, out: Matrix
) -> None:
    """Fill `out` (3, n) with smoothed acceleration, velocity and effort, SI.

    The filter has w samples. It does not fit at the ends: the first and last (w - 1)/2 columns of
    `out` are not written.

    Parameters
    ----------
    position, effort
        Measured position (n,) [rad | m] and effort (n,) [N m | N].
    c
        Second-derivative filter (w,) [1/s^2], symmetric, from position to acceleration.
    g
        Smoothing kernel (w - 2,), symmetric with sum 1, for velocity and effort.
    held
        Weights (3,) of the efforts before, at and after a sample (`effort_weights`).
    period
        Sample period [s].
    out
        Result (3, n): acceleration, velocity, effort.
    """
    n, window = position.shape[0], c.shape[0]
    reach = (window - 1) // 2
    x = np.empty(BLOCK + window - 1)
    v = np.empty(BLOCK + window - 3)
    u = np.empty(BLOCK + window - 3)
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
        acceleration = out[0, first : first + rows]
        velocity = out[1, first : first + rows]
        mean = out[2, first : first + rows]
        out[:, first : first + rows] = 0.0
        for j in range(window):
            for k in range(rows):
                acceleration[k] += c[j] * x[k + j]
        for j in range(window - 2):
            for k in range(rows):
                velocity[k] += g[j] * v[k + j]
                mean[k] += g[j] * u[k + j]


def smoothed(record: MotionRecord, window: int) -> tuple[Vector, Vector, Vector]:
    """Return smoothed acceleration, velocity and effort (n,) of a record in SI units.

    The first and the last (window - 1)/2 values of each signal are NaN.
    """
    return smoothed_by(record, smoothing_kernel(window, record.period))


def smoothed_by(record: MotionRecord, g: Vector) -> tuple[Vector, Vector, Vector]:
    """Return acceleration, velocity and effort (n,), smoothed by a symmetric kernel g of sum 1.

    Because of the second difference, each value depends on `window` samples; `window` is the length
    of g plus 2. The first and last (window - 1)/2 values of each signal are therefore NaN.
    """
    window = g.size + 2
    out = np.empty((3, record.position.size))
    n = record.position.size
    reach = (window - 1) // 2
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
            np.array(effort_weights(record.period, record.effort_lag)),
            record.period,
            out,
        )
    return out[0], out[1], out[2]
