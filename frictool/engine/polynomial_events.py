"""First time at which a polynomial falls to zero, for events on a trajectory.

    p(t) = c[0] + c[1] t + ... + c[n-1] t^(n-1)          0 <= t <= h

No zero between two evaluated points a and b is missed, because |p''| <= bound:

    p(t) >= min(p(a), p(b)) - bound (b - a)^2 / 8        on [a, b]
"""

from __future__ import annotations

from frictool.engine.safeguarded_newton import MAX_ITERATIONS, bracket_step
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

NEVER = -1.0
RESOLUTION = 2.0**-40  # shortest distance of two zeros that the search separates, relative to h
MAX_HALVINGS = 10_000  # largest number of iterations; if the polynomial nearly touches 0, about 100


@kernel
def value(c: Vector, t: float) -> float:
    """Return the polynomial p(t) with the coefficients c, lowest power first, by Horner's rule."""
    total = 0.0
    for k in range(c.shape[0] - 1, -1, -1):
        total = total * t + c[k]
    return total


@kernel
def value_and_slope(c: Vector, t: float) -> tuple[float, float]:
    """Return the polynomial p(t) with the coefficients c, and its derivative p'(t)."""
    total, rate = 0.0, 0.0
    for k in range(c.shape[0] - 1, -1, -1):
        rate = rate * t + total
        total = total * t + c[k]
    return total, rate


@kernel
def curvature_bound(c: Vector, h: float) -> float:
    """Return an upper bound of |p''(t)| on [0, h] for the polynomial p with the coefficients c."""
    total = 0.0
    for k in range(c.shape[0] - 1, 1, -1):
        total = total * h + k * (k - 1) * abs(c[k])
    return total


@kernel
def _root(c: Vector, low: float, high: float, start: float, end: float) -> float:
    t = low + (high - low) * (start / (start - end))
    for _ in range(MAX_ITERATIONS):
        ahead, rate = value_and_slope(c, t)
        low, high, t, is_root = bracket_step(t, ahead, rate, low, high)
        if is_root:
            break
    return t


@kernel
def _first_zero(c: Vector, h: float) -> float:
    bound = curvature_bound(c, h)
    low = 0.0
    width = h
    start = c[0]
    leaving = c[1] if c.shape[0] > 1 else 0.0
    for _ in range(MAX_HALVINGS):
        high = min(low + width, h)
        width = high - low
        end, arriving = value_and_slope(c, high)
        change = bound * width
        tiny = width <= RESOLUTION * h
        if end <= 0.0 and (tiny or min(leaving, arriving) < -change):
            return _root(c, low, high, start, end)
        if end > 0.0 and (
            tiny or min(start, end) > 0.125 * change * width or abs(leaving) > change
        ):
            if high >= h:
                return NEVER
            low = high
            start = end
            leaving = arriving
            width = 2.0 * width
        else:
            width *= 0.5
    return NEVER


@kernel
def first_fall(c: Vector, h: float) -> float:
    """Return the first t in [0, h] at which a polynomial p falls to zero from above.

    The result is NEVER (-1) if p does not fall to zero in this interval. The result is 0 if
    p(0) < 0, or if p(0) = 0 and p falls. If p(0) = 0 and p rises, the zero at t = 0 is ignored,
    because it is the start of a motion and not a stop.
    """
    if h <= 0.0:
        return NEVER
    lead = 0
    while lead < c.shape[0] and c[lead] == 0.0:
        lead += 1
    if lead == c.shape[0]:
        return NEVER
    if c[lead] < 0.0:
        return 0.0
    terms = c.shape[0]
    while c[terms - 1] == 0.0:
        terms -= 1
    return _first_zero(c[lead:terms], h)
