"""Brent's search for a minimum in an interval, for Python and for kernels.

The method combines parabolic interpolation and golden section (R. Brent, Algorithms for
Minimization without Derivatives, 1973, chapter 5). The import of scipy.optimize would take longer
than the searches of an identification.

The state of a search is a list or an array of ten numbers, in this order:

- the two ends of the interval
- argument and value of the three best points so far, the best first
- the last step, and the step before the last step
"""

from __future__ import annotations

import math
from collections.abc import Callable

from frictool.typing import Vector

LOW, HIGH, BEST, LEAST, SECOND, AT_SECOND, THIRD, AT_THIRD, STEP, STEP_BEFORE = range(10)
SMALL_PART = 0.5 * (3.0 - math.sqrt(5.0))  # golden section: smaller part of an interval
MOST_STEPS = 500  # largest number of evaluations after the first
ROUNDING = 1.5e-8  # least relative error of a minimum: square root of the rounding error


def bounded_minimum(
    value: Callable[[float], float], low: float, high: float, tolerance: float = 1e-5
) -> float:
    """Return an argument between `low` and `high` at which `value` has a local minimum.

    Parameters
    ----------
    value
        Continuous function of one argument.
    low
        Start of the searched interval.
    high
        End of the searched interval.
    tolerance
        Allowed error of the result, in the unit of the argument; 3e-8 times the argument is added.

    Returns
    -------
    float
        The evaluated argument with the smallest value.
    """
    start = low + SMALL_PART * (high - low)
    state = [low, high, *3 * [start, value(start)], 0.0, 0.0]
    for _ in range(MOST_STEPS):
        argument = next_argument(state, ROUNDING * abs(state[BEST]) + tolerance / 3.0)
        if math.isnan(argument):
            break
        update_search(state, argument, value(argument))
    return state[BEST]


def next_argument(state: list[float] | Vector, resolved: float) -> float:
    """Return the argument at which the function is evaluated next, and record the step in `state`.

    The next argument is at least `resolved` away from the best argument. The result is NaN if both
    ends of the interval are within twice `resolved` of the best argument.
    """
    low, high, best = state[LOW], state[HIGH], state[BEST]
    middle = 0.5 * (low + high)
    if abs(best - middle) <= 2.0 * resolved - 0.5 * (high - low):
        return math.nan
    # the vertex of the parabola is at best + top/bottom
    r = (best - state[SECOND]) * (state[LEAST] - state[AT_THIRD])
    q = (best - state[THIRD]) * (state[LEAST] - state[AT_SECOND])
    top = (best - state[SECOND]) * r - (best - state[THIRD]) * q
    bottom = 2.0 * (q - r)
    if bottom < 0.0:
        top = -top
        bottom = -bottom
    if (
        2.0 * abs(top) < bottom * abs(state[STEP_BEFORE])
        and bottom * (low - best) < top < bottom * (high - best)
    ):  # fmt: skip
        state[STEP_BEFORE] = state[STEP]
        step = top / bottom
        if min(best + step - low, high - best - step) < 2.0 * resolved:
            step = math.copysign(resolved, middle - best)
    else:
        state[STEP_BEFORE] = (low if best >= middle else high) - best
        step = SMALL_PART * state[STEP_BEFORE]
    state[STEP] = step
    return float(best + math.copysign(max(abs(step), resolved), step))


def update_search(state: list[float] | Vector, argument: float, value: float) -> None:
    """Narrow the interval in `state` with the value of the function at `argument`."""
    best = state[BEST]
    if value <= state[LEAST]:
        state[LOW if argument >= best else HIGH] = best
        state[THIRD] = state[SECOND]
        state[AT_THIRD] = state[AT_SECOND]
        state[SECOND] = best
        state[AT_SECOND] = state[LEAST]
        state[BEST] = argument
        state[LEAST] = value
        return
    state[LOW if argument < best else HIGH] = argument
    if value <= state[AT_SECOND] or state[SECOND] == best:
        state[THIRD] = state[SECOND]
        state[AT_THIRD] = state[AT_SECOND]
        state[SECOND] = argument
        state[AT_SECOND] = value
    elif value <= state[AT_THIRD] or state[THIRD] in (best, state[SECOND]):
        state[THIRD] = argument
        state[AT_THIRD] = value
