"""When motion began, from what the encoder saw of it afterwards.

Under an effort that grows at a rate r, an axis that breaks away at t0 moves by (viscous/J = l, excess = |effort(t0)| - coulomb)

    s(t) = excess/J t^2 phi2(-l t) + r/J t^3 phi3(-l t)        phi2(x) = (e^x - 1 - x)/x^2, phi3(x) = (phi2(x) - 1/2)/x

What a coarse encoder tells well is when it changes: half a sample before the change was seen, s = start + (counts before), where
`start`, from the place of rest to the first change, is unknown between 0 and one count. t0 minimises the squares of the differences
in s, `start` eliminated; the excess follows t0 along the ramp. A preference for the `expected` start, worth `timing` squares, decides what
the changes leave open: `timing` is the variance of s at a change (half a sample of motion) over that of a uniform start, 1/12 count^2. A
single change cannot tell t0 from `start`, and there the preference decides alone.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.exponentials import phi2
from frictool.identify.record import Vector
from frictool.kernels import kernel

OK, NO_MOTION, NOT_POSITIVE = 0, 1, 2
STATUS = {OK: "onset found", NO_MOTION: "no change after the onset", NOT_POSITIVE: "rate, inertia or search span is not positive"}
COARSE, HALVINGS = 64, 40  # points of the first search; steps of the golden section around the best


@kernel
def phi3(x: float) -> float:
    """(e^x - 1 - x - x^2/2)/x^3."""
    if abs(x) > 1.0:
        return (phi2(x) - 0.5) / x
    total, term = 0.0, 1.0 / 6.0
    for k in range(4, 23):
        total += term
        term *= x / k
    return total


@kernel
def travel(t: float, excess: float, rate: float, inertia: float, viscous: float) -> float:
    """s(t), rad | m, of the formula above; 0 for t <= 0. An excess below zero counts as zero."""
    if t <= 0.0:
        return 0.0
    x = -viscous / inertia * t
    return t * t / inertia * (max(excess, 0.0) * phi2(x) + rate * t * phi3(x))


@kernel
def misfit(
    t0: float, time: Vector, seen: Vector, ramp: Vector, axis: Vector, resolution: float, expected: float, timing: float
) -> tuple[float, float]:
    """(sum of squares of the model's travel against start + `seen` (n,) at `time` (n,), the start that makes it least, within one count).

    ramp: (|effort| at time 0, its rate per s); axis: (inertia, viscous, coulomb); expected: the start preferred, rad | m.
    timing: see above.
    """
    excess = ramp[0] + ramp[1] * t0 - axis[2]
    n = time.shape[0]
    total, square = 0.0, 0.0
    for k in range(n):
        error = travel(time[k] - t0, excess, ramp[1], axis[0], axis[1]) - seen[k]
        total += error
        square += error * error
    start = min(max((total + timing * expected) / (n + timing), 0.0), resolution)
    left: float = square - 2.0 * start * total + n * start * start + timing * (start - expected) ** 2
    return left, start


@kernel
def onset_time(
    time: Vector, seen: Vector, ramp: Vector, axis: Vector, resolution: float, expected: float, timing: float, span: float
) -> tuple[float, float, int]:
    """(t0 [s], start [rad | m], status): the onset within `span` s before time[0]; arguments as in `misfit`. Status: see STATUS."""
    if time.shape[0] == 0:
        return math.nan, math.nan, NO_MOTION
    if not (span > 0.0 and ramp[1] > 0.0 and axis[0] > 0.0):
        return math.nan, math.nan, NOT_POSITIVE
    step = span / COARSE
    best, least = time[0], math.inf
    for k in range(COARSE + 1):
        t0 = time[0] - k * step
        value = misfit(t0, time, seen, ramp, axis, resolution, expected, timing)[0]
        if value < least:
            best, least = t0, value
    low, high = best - step, min(best + step, time[0])
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(HALVINGS):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        if (
            misfit(left, time, seen, ramp, axis, resolution, expected, timing)[0]
            <= misfit(right, time, seen, ramp, axis, resolution, expected, timing)[0]
        ):
            high = right
        else:
            low = left
    t0 = 0.5 * (low + high)
    return t0, misfit(t0, time, seen, ramp, axis, resolution, expected, timing)[1], OK


def search_span(resolution: float, rate: float, inertia: float, counts: float) -> float:
    """The longest time, s, in which `counts` counts can pass under a ramp of `rate` when nothing but the ramp accelerates."""
    return float(np.cbrt(6.0 * counts * resolution * inertia / rate))
