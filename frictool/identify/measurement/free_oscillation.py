"""Free oscillation of the position in a window of time after a stop.

    x(t) = c + d t + e^(-s t) (p cos w t + q sin w t)

w is the angular frequency, and s the decay rate. On a rigid axis, the effort or a load over the
position causes each acceleration that opposes the displacement. An elastic drive train or an
elastic contact oscillates without such an effort:

    share = Re(U conj(a)) / (J |a|^2) + k/(J w^2)

- U, a: complex amplitudes of the effort and of the acceleration
- J: inertia; k: stiffness of the load over the position

`share` is about 1 if a controller or a load makes a rigid axis oscillate, and small in a free
oscillation. The logged effort can lead or lag the position. The largest `share` over a range of
delays is used.

The best point of a grid over w and s is the start of Gauss-Newton steps. The standard errors allow
for correlation of the residuals of neighbouring samples, and for the rounding to encoder counts.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.typing import Matrix, Vector

LEAST_CYCLES, MOST_CYCLES = 3.0, 12.0  # bounds of the grid of w, in cycles per window
FREQUENCIES = 28  # number of values of w in the grid
DECAYS = (0.0, 1.0, 2.5, 5.0)  # grid of s, times the window's duration
STEPS = 6  # largest number of Gauss-Newton steps
CONVERGED = 1e-4  # relative change of w at which the steps end
COARSE = 0.6  # least share of the variance that the best point of the grid explains
EXPLAINED = 0.8  # least share of the variance that the oscillation explains
# largest damping ratio; with a larger one, the motion hardly differs from a smooth approach
MOST_DAMPING = 0.25
VISIBLE = 2.0  # number of cycles after which the amplitude must still be at least one count
MOVED = 2.0  # least motion before the window, in amplitudes
DRIVEN = 0.5  # value of `share` from which the effort may cause the oscillation
DELAYS = 9  # number of tested delays of the effort


class Rigidity(NamedTuple):
    """Properties of an axis that predict its oscillations under the assumption that it is rigid.

    - inertia: smallest inertia, kg m^2 | kg
    - late: longest delay between effort and position, in either direction, s
    - load: function that returns the load (n,) at positions (n,), or None
    """

    inertia: float
    late: float
    load: Callable[[Vector], Vector] | None


class StopWindow(NamedTuple):
    """Window after a stop.

    - position, effort: equidistant samples (n,), rad | m and N m | N
    - period: sample period, s
    - distance_before: largest distance between the positions before the window and the window's
      mean, rad | m
    - resolution: encoder count, rad | m
    """

    position: Vector
    effort: Vector
    period: float
    distance_before: float
    resolution: float


class FreeOscillation(NamedTuple):
    """Oscillation after one stop.

    - rate, rate_error: angular frequency w and its standard error, rad/s
    - decay, decay_error: decay rate s and its standard error, 1/s
    - amplitude: amplitude at the start of the window, rad | m
    - share, share_error: `share` of the module docstring, and its standard error
    """

    rate: float
    rate_error: float
    decay: float
    decay_error: float
    amplitude: float
    share: float
    share_error: float


@functools.cache
def _grid(samples: int) -> tuple[Vector, Vector, Matrix]:
    """Return a grid of g pairs (w, s), and the columns (4 g, samples) of a fit for each pair.

    The module docstring defines w and s; here they are multiplied by the duration of a window. A
    pair has four orthonormal columns. The first two of them span the constant and the slope.
    """
    time = np.arange(samples) / samples
    cycles = np.geomspace(LEAST_CYCLES, MOST_CYCLES, FREQUENCIES)
    rate, decay = (one.ravel() for one in np.meshgrid(2.0 * np.pi * cycles, DECAYS, indexing="ij"))
    possible = decay <= MOST_DAMPING * rate
    rate, decay = rate[possible], decay[possible]
    columns = np.stack([_columns(time, *one) for one in zip(rate, decay, strict=True)])
    basis = np.linalg.qr(columns)[0].transpose(0, 2, 1)
    return rate, decay, np.ascontiguousarray(basis.reshape(-1, samples))


def _columns(time: Vector, rate: float, decay: float) -> Matrix:
    envelope = np.exp(-decay * time)
    turn = rate * time
    return np.column_stack(
        [np.ones_like(time), time, envelope * np.cos(turn), envelope * np.sin(turn)]
    )


def coarse_fits(windows: Matrix, highest: float) -> list[tuple[int, float, float]]:
    """Return (index in `windows`, w, s) of at most two windows with an oscillation.

    `windows` is (m, n). w is the angular frequency and s the decay rate, both times the duration of
    a window. The chosen windows are: the window whose oscillation explains the largest fraction of
    the variance, and the last window whose oscillation explains at least the fraction EXPLAINED.
    The first of these may contain the end of the motion. The list is empty if no oscillation
    explains the fraction COARSE. `highest` is the largest allowed product of w and the duration.
    """
    rate, decay, basis = _grid(windows.shape[1])
    about_mean = windows - windows.mean(axis=1, keepdims=True)
    squares = ((about_mean @ basis.T) ** 2).reshape(len(windows), rate.size, 4)
    straight = squares[:, :1, :2].sum(axis=2)
    total = np.sum(about_mean**2, axis=1, keepdims=True) - straight
    explained = (squares.sum(axis=2) - straight) / np.maximum(total, np.finfo(float).tiny)
    explained[:, rate > highest] = 0.0
    most = explained.max(axis=1)
    chosen = {int(np.argmax(most))} if most.max() >= COARSE else set[int]()
    chosen.update(np.flatnonzero(most >= EXPLAINED)[-1:].tolist())
    best = np.argmax(explained, axis=1)
    return [
        (window, float(rate[k]), float(decay[k]))
        for window in sorted(chosen)
        for k in [best[window]]
    ]


def free_oscillation(
    stop: StopWindow, rate: float, decay: float, axis: Rigidity
) -> FreeOscillation | None:
    """Return the free oscillation in `stop`, or None if the motion is not a free oscillation.

    rate, decay: start values of the angular frequency [rad/s] and of the decay rate [1/s].
    """
    time: Vector = stop.period * np.arange(stop.position.size, dtype=np.float64)
    position: Vector = stop.position - float(stop.position.mean())
    fitted = _refined(time, position, rate, decay)
    if fitted is None:
        return None
    rate, decay, values = fitted
    amplitude = math.hypot(values[2], values[3])
    columns = _columns(time, rate, decay)
    residual = position - columns @ values
    straight = np.polyval(np.polyfit(time, position, 1), time) - position
    cycles = rate * (time[-1] + stop.period) / (2.0 * np.pi)
    if (
        residual @ residual > (1.0 - EXPLAINED) * (straight @ straight)
        or decay > MOST_DAMPING * math.hypot(rate, decay)
        or not LEAST_CYCLES / 1.1 < cycles < 1.1 * MOST_CYCLES
        or amplitude * math.exp(-2.0 * np.pi * VISIBLE * decay / rate) < stop.resolution
        or abs(values[1]) * time[-1] > amplitude
        or stop.distance_before < MOVED * amplitude
    ):
        return None
    motion = complex(values[2], -values[3])
    share, share_error = _share(stop, columns, complex(-decay, rate), motion, axis)
    if share > DRIVEN:
        return None
    errors = _standard_errors(_derivatives(time, columns, values), residual, stop.resolution)
    return FreeOscillation(
        rate, float(errors[-2]), decay, float(errors[-1]), amplitude, share, share_error
    )


def _refined(
    time: Vector, position: Vector, rate: float, decay: float
) -> tuple[float, float, Vector] | None:
    """Return w, s and (c, d, p, q) of x(t) (module docstring); `rate`, `decay` start the search.

    The result is None if the steps lead to w <= 0 or to |s| > w.
    """
    columns = _columns(time, rate, decay)
    values = _fitted(columns, position)
    residual = position - columns @ values
    for _ in range(STEPS):
        whole = _derivatives(time, columns, values)
        change = _fitted(whole, residual)[-2:]
        faster, sooner = rate + float(change[0]), decay + float(change[1])
        if faster <= 0.0 or abs(sooner) > faster:
            return None
        columns = _columns(time, faster, sooner)
        other = _fitted(columns, position)
        left = position - columns @ other
        if left @ left > residual @ residual:
            break
        rate, decay, values, residual = faster, sooner, other, left
        if abs(change[0]) < CONVERGED * rate:
            break
    return rate, decay, values


def _fitted(columns: Matrix, values: Vector) -> Vector:
    """Return the coefficients of the columns (n, k) in the least squares fit to the values (n,)."""
    return np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0], dtype=np.float64)


def _derivatives(time: Vector, columns: Matrix, values: Vector) -> Matrix:
    """Return the derivatives (n, 6) of x(t) (module docstring) with respect to c, d, p, q, w, s."""
    cosine, sine = columns[:, 2], columns[:, 3]
    by_rate = time * (values[3] * cosine - values[2] * sine)
    by_decay = -time * (values[2] * cosine + values[3] * sine)
    return np.column_stack([columns, by_rate, by_decay])


def _standard_errors(columns: Matrix, residual: Vector, resolution: float) -> Vector:
    """Return the standard errors of the coefficients of the columns (n, k)."""
    free = len(columns) - columns.shape[1]
    square = float(residual @ residual)
    variance = max(square / free, resolution**2 / 12.0)
    near = min(max(float(residual[1:] @ residual[:-1]) / max(square, 1e-300), 0.0), 0.9)
    scale = np.linalg.norm(columns, axis=0)
    inverse = np.linalg.pinv((columns / scale).T @ (columns / scale))
    return np.asarray(np.sqrt(variance * (1.0 + near) / (1.0 - near) * np.diag(inverse)) / scale)


def _share(
    stop: StopWindow, columns: Matrix, pole: complex, motion: complex, axis: Rigidity
) -> tuple[float, float]:
    """Return `share` of the module docstring, and its standard error.

    motion: complex amplitude of the position Re(motion exp(pole t)); pole = -s + i w.
    """
    values = _fitted(columns, stop.effort)
    residual = stop.effort - columns @ values
    error = float(np.linalg.norm(_standard_errors(columns, residual, 0.0)[2:]))
    acceleration = pole**2 * motion
    delays = axis.late * np.linspace(-1.0, 1.0, DELAYS)
    push = complex(values[2], -values[3]) * np.exp(1j * pole.imag * delays)
    size = abs(acceleration)
    restoring = float(np.max((push * acceleration.conjugate()).real)) / size
    if axis.load is not None:
        centre, reach = float(stop.position.mean()), abs(motion)
        ends = axis.load(np.array([centre - reach, centre + reach]))
        restoring += float(ends[1] - ends[0]) / 2.0
    return restoring / (axis.inertia * size), error / (axis.inertia * size)
