"""Time of the onset of motion, computed from the encoder's changes after the onset.

A change is a sample at which the encoder's count differs from the previous count. Under an effort
that grows at a rate r, an axis of inertia J breaks away at t0, and friction drops immediately to
Coulomb friction. In the time t after t0, the axis moves by

    s(t) = excess/J t^2 phi2(-l t) + r/J t^3 phi3(-l t)
    excess = |effort(t0)| - coulomb,   l = viscous/J
    phi2(x) = (e^x - 1 - x)/x^2
    phi3(x) = (phi2(x) - 1/2)/x

On average, the axis passes an edge of the encoder half a sample before the log shows the change.
Let t_k be this time for change k. At t_k, the axis has moved by s_k = start + (distance from the
first change to change k). `start`, the distance from the rest position to the first edge, is
unknown and at most one count. t0 and `start` minimise the sum of the squared differences s_k -
s(t_k - t0). The excess at t0 follows from the ramp.

The changes may not determine `start`; a single change never does. Another term of the sum therefore
prefers the value `expected` of `start`. The weight `timing` of this term is a ratio of two
variances: the variance of s_k that sampling causes, and the variance 1/12 count^2 of a uniformly
distributed start.

If a Stribeck velocity v_s > 0 is assumed, friction at the speed v is lower than the breakaway by
excess (1 - exp(-(v/v_s)^exponent)). s(t) is then a table from a numerical integration, which uses
the excess at the previous estimate of t0. Table and t0 are recomputed ROUNDS times. From the second
round on, s(t) is linear in the excess between the last two tables (secant method).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.exponential_integrals import phi2
from frictool.identify.regression import brent_minimum
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Matrix, Vector

Table = NDArray[np.float64]
Tables = NDArray[np.float64]  # tables of several onsets
OK, NO_MOTION, NOT_POSITIVE = 0, 1, 2
STATUS = {
    OK: "onset found",
    NO_MOTION: "no change after the onset",
    NOT_POSITIVE: "rate, inertia or search span is not positive",
}
STEPS = 48  # steps of the travel table; step k ends at (k/STEPS)^2 of its duration
ROUNDS = 3  # iterations between the onset and its excess
COARSE = 16  # intervals of the grid in which the search starts
MOST_STEPS = 40  # largest number of steps of Brent's method around the best grid point
next_argument = kernel(brent_minimum.next_argument)
update_search = kernel(brent_minimum.update_search)
RESOLVED = 1e-8  # error of the onset time at the end of the search, relative to the search span


@kernel
def phi3(x: float) -> float:
    """Return (e^x - 1 - x - x^2/2)/x^3, also for x near 0."""
    if abs(x) > 1.0:
        return (phi2(x) - 0.5) / x
    total = 0.0
    term = 1.0 / 6.0
    for k in range(4, 23):
        total += term
        term *= x / k
    return total


@kernel
def travel(t: float, excess: float, rate: float, inertia: float, viscous: float) -> float:
    """Return the travel s(t) [rad | m] at the time t [s] after the onset (module docstring).

    The travel is 0 for t <= 0. A negative `excess` is replaced by 0.
    """
    if t <= 0.0:
        return 0.0
    x = -viscous / inertia * t
    return t * t / inertia * (max(excess, 0.0) * phi2(x) + rate * t * phi3(x))


@kernel
def write_travel_tables(
    duration: Vector,
    excess: Vector,
    rate: Vector,
    axes: Matrix,
    velocity: float,
    exponent: float,
    tables: Tables,
) -> None:
    """Write to `tables` the travel as cubic polynomials of the time t since the onset.

    `tables` has the shape (m, STEPS, 6).

    Row k of an onset is valid from t = duration * (k/STEPS)^2 to t = duration * ((k + 1)/STEPS)^2.
    The columns are the start of this interval [s], 1/length [1/s], and the four coefficients,
    constant first, of a cubic in (t - start)/length.

    `duration` [s] and `excess` [N m | N] are (m,); `axes` (m, 3) contains inertia, viscous and
    Coulomb friction of each onset. Friction decreases by `excess`, from the breakaway to Coulomb
    friction, with the Stribeck velocity `velocity`; if `velocity` is inf, friction does not
    decrease. The method is Runge-Kutta of order four, with short steps just after the onset, where
    friction changes fast.
    """
    m = duration.shape[0]
    slopes = np.empty((4, m))
    s = np.empty(m)
    v = np.empty(m)
    for j in range(m):
        s[j] = 0.0
        v[j] = 0.0
    for k in range(STEPS):
        for stage in range(4):
            for j in range(m):
                begin = duration[j] * (k / STEPS) ** 2
                step = duration[j] * ((k + 1) / STEPS) ** 2 - begin
                at = v[j]
                if stage > 0:
                    at = v[j] + (step if stage == 3 else 0.5 * step) * slopes[stage - 1, j]
                t = begin + step * (0.0 if stage == 0 else 1.0 if stage == 3 else 0.5)
                ratio = at / velocity
                # a general power takes several times as long as a product or a root
                if exponent == 2.0:
                    power = ratio * ratio
                elif exponent == 1.0:
                    power = ratio
                elif exponent == 0.5:
                    power = math.sqrt(ratio)
                else:
                    power = ratio**exponent
                fallen = -math.expm1(-power)
                drive = rate[j] * t + max(excess[j], 0.0) * fallen
                slopes[stage, j] = (drive - axes[j, 1] * at) / axes[j, 0]
        for j in range(m):
            begin = duration[j] * (k / STEPS) ** 2
            step = duration[j] * ((k + 1) / STEPS) ** 2 - begin
            rise = step * (v[j] + step / 6.0 * (slopes[0, j] + slopes[1, j] + slopes[2, j]))
            left = step * v[j]
            v[j] += (
                step / 6.0 * (slopes[0, j] + 2.0 * slopes[1, j] + 2.0 * slopes[2, j] + slopes[3, j])
            )
            right = step * v[j]
            tables[j, k, 0] = begin
            tables[j, k, 1] = 1.0 / step
            tables[j, k, 2] = s[j]
            tables[j, k, 3] = left
            tables[j, k, 4] = 3.0 * rise - 2.0 * left - right
            tables[j, k, 5] = left + right - 2.0 * rise
            s[j] += rise


@kernel
def looked_up(t: float, duration: float, tables: Tables, share: float) -> float:
    """Return the travel [rad | m] at t [s] after the onset; 0 for t <= 0.

    `tables` (2, STEPS, 6): written by `write_travel_tables` for two values of `excess`. The travel
    is extrapolated linearly: (1 + `share`) times the travel from the second table, minus `share`
    times the travel from the first table.
    """
    if t <= 0.0:
        return 0.0
    k = min(int(STEPS * math.sqrt(t / duration)), STEPS - 1)
    x = (t - tables[1, k, 0]) * tables[1, k, 1]
    latest: float = tables[1, k, 2] + x * (
        tables[1, k, 3] + x * (tables[1, k, 4] + x * tables[1, k, 5])
    )
    if share == 0.0:
        return latest
    earlier: float = tables[0, k, 2] + x * (
        tables[0, k, 3] + x * (tables[0, k, 4] + x * tables[0, k, 5])
    )
    return latest + share * (latest - earlier)


@kernel
def misfit(
    t0: float,
    time: Vector,
    seen: Vector,
    ramp: Vector,
    axis: Vector,
    resolution: float,
    expected: float,
    timing: float,
    duration: float,
    excesses: Vector,
    tables: Tables,
) -> tuple[float, float]:
    """Return the weighted sum of squares for the onset time `t0` [s], and the start [rad | m].

    The start is the distance from the rest position to the first change. The sum of squares is
    `timing` (start - `expected`)^2, plus (travel - start - `seen`)^2 for each change. The returned
    start minimises this sum.

    - time: times at which the encoder's count changes, (n,), s
    - seen: distance from the first change to each change, (n,), rad | m
    - ramp: |effort| at time 0 [N m | N], and its slope [N m/s | N/s]
    - axis: inertia, viscous and Coulomb friction in SI units
    - expected: preferred start, rad | m
    - timing: weight of the preferred start; the weight of a change is 1 (module docstring)
    - resolution: encoder step, rad | m; the start is between 0 and one step
    - duration, tables: arguments of `looked_up`; if `tables` is empty, friction drops immediately
    - excesses: excess of each table, (2,), N m | N; the travel is linear in the excess, and is
      extrapolated by at most the difference between the tables
    """
    excess = ramp[0] + ramp[1] * t0 - axis[2]
    change = excesses[1] - excesses[0]
    share = 0.0
    if change != 0.0:
        share = min(max((excess - excesses[1]) / change, -1.0), 1.0)
    n = time.shape[0]
    total, square = 0.0, 0.0
    for k in range(n):
        late = time[k] - t0
        moved = (
            looked_up(late, duration, tables, share)
            if tables.shape[0] > 0
            else travel(late, excess, ramp[1], axis[0], axis[1])
        )
        error = moved - seen[k]
        total += error
        square += error * error
    start = min(max((total + timing * expected) / (n + timing), 0.0), resolution)
    left: float = (
        square - 2.0 * start * total + n * start * start + timing * (start - expected) ** 2
    )
    return left, start


@kernel
def least_misfit(
    time: Vector,
    seen: Vector,
    ramp: Vector,
    axis: Vector,
    resolution: float,
    expected: float,
    timing: float,
    span: float,
    duration: float,
    excesses: Vector,
    tables: Tables,
) -> float:
    """Return the onset time [s] that minimises `misfit`; it is at most `span` s before time[0].

    `misfit` explains the other arguments.
    """
    step = span / COARSE
    best = time[0]
    least = math.inf
    for k in range(COARSE + 1):
        t0 = time[0] - k * step
        value = misfit(
            t0, time, seen, ramp, axis, resolution, expected, timing, duration, excesses, tables
        )[0]
        if value < least:
            best, least = t0, value
    state = np.empty(10)
    state[0], state[1] = best - step, min(best + step, time[0])
    for k in range(2, 8, 2):
        state[k], state[k + 1] = best, least
    state[8], state[9] = 0.0, 0.0
    for _ in range(MOST_STEPS):
        t0 = next_argument(state, RESOLVED * span)
        if math.isnan(t0):
            break
        value = misfit(
            t0, time, seen, ramp, axis, resolution, expected, timing, duration, excesses, tables
        )[0]
        update_search(state, t0, value)
    found: float = state[brent_minimum.BEST]
    return found


@kernel
def onset_times(
    times: Matrix,
    seen: Matrix,
    counts: IntVector,
    ramps: Matrix,
    axes: Matrix,
    resolution: float,
    expected: float,
    timing: Vector,
    span: Vector,
    velocity: float,
    exponent: float,
    immediate: Vector,
) -> Matrix:
    """Return t0 [s], start [rad | m], misfit and status code of m onsets, (m, 4).

    - times, seen: `time` and `seen` of each onset in the first columns of a row, (m, n)
    - counts: number of encoder changes of each onset, (m,)
    - ramps, axes: `ramp` and `axis` of each onset, (m, 2) and (m, 3)
    - span: length of the searched interval before the first change, (m,), s
    - velocity: Stribeck velocity, rad/s | m/s; 0 if friction drops immediately at the onset, inf if
      friction does not decrease
    - exponent: exponent of the Stribeck curve
    - immediate: onset times computed with the Stribeck velocity 0, (m,), s, from which the
      iteration starts; NaN for an onset time that is not known yet

    The other arguments are explained in `misfit`.
    """
    m = counts.shape[0]
    found = np.empty((m, 4))
    t0 = np.empty(m)
    duration = np.empty(m)
    excess = np.empty(m)
    rate = np.empty(m)
    for j in range(m):
        for column in range(3):
            found[j, column] = math.nan
        t0[j] = immediate[j]
        duration[j] = 1.0
        rate[j] = ramps[j, 1]
        if counts[j] == 0:
            found[j, 3] = NO_MOTION
        elif not (span[j] > 0.0 and rate[j] > 0.0 and axes[j, 0] > 0.0):
            found[j, 3] = NOT_POSITIVE
        else:
            found[j, 3] = OK
            length = times[j, counts[j] - 1] - times[j, 0]
            duration[j] = length + span[j] * (1.0 + 1.0 / COARSE)
    excesses = np.empty((m, 2))
    tables = np.empty((m, 0, STEPS, 6))
    for trial in range(1 + (ROUNDS if velocity > 0.0 else 0)):
        if trial > 0:
            if trial == 1:
                tables = np.empty((m, 2, STEPS, 6))
            for j in range(m):
                excess[j] = ramps[j, 0] + rate[j] * t0[j] - axes[j, 2]
                excesses[j, 0] = excess[j] if trial == 1 else excesses[j, 1]
                excesses[j, 1] = excess[j]
            for j in range(m):  # numba takes seconds to compile an assignment of slices
                for k in range(STEPS):
                    for column in range(6):
                        tables[j, 0, k, column] = tables[j, 1, k, column]
            write_travel_tables(duration, excess, rate, axes, velocity, exponent, tables[:, 1])
        for j in range(m):
            if found[j, 3] == OK and (trial > 0 or math.isnan(t0[j])):
                t0[j] = least_misfit(
                    times[j, : counts[j]],
                    seen[j, : counts[j]],
                    ramps[j],
                    axes[j],
                    resolution,
                    expected,
                    timing[j],
                    span[j],
                    duration[j],
                    excesses[j],
                    tables[j],
                )
    for j in range(m):
        if found[j, 3] == OK:
            left, start = misfit(
                t0[j],
                times[j, : counts[j]],
                seen[j, : counts[j]],
                ramps[j],
                axes[j],
                resolution,
                expected,
                timing[j],
                duration[j],
                excesses[j],
                tables[j],
            )
            found[j, 0] = t0[j]
            found[j, 1] = start
            found[j, 2] = left
    return found


def search_span(resolution: float, rate: Vector, inertia: float, counts: float) -> Vector:
    """Return the times (m,) [s] in which ramps of effort move an inertia by `counts` encoder steps.

    The effort starts at 0 and grows at `rate` (m,) [N m/s | N/s]. No friction acts on the inertia.
    """
    return np.asarray(np.cbrt(6.0 * counts * resolution * inertia / rate))
