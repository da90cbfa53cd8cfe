"""Bracketed root search: Newton's step if it stays inside the bracket, else bisection."""

from __future__ import annotations

from frictool.runtime.kernels import inner_kernel

ROUNDING = 2.0**-52
MAX_ITERATIONS = 200  # limit of iterations; bisection alone needs 60 to 110


@inner_kernel
def bracket_step(
    t: float, ahead: float, slope: float, low: float, high: float
) -> tuple[float, float, float, bool]:
    """Take one step towards the root in [low, high] of a falling function.

    ahead, slope: value and derivative of the function at t. Returns low, high, the next t, and True
    if this t is the root.
    """
    if ahead > 0.0:
        low = t
    else:
        high = t
    new = t - ahead / slope if slope < 0.0 else low
    if ahead == 0.0 or (slope < 0.0 and abs(new - t) <= ROUNDING * t):
        # tested before the bracket, because t is now one of its ends
        return low, high, t, True
    if not low < new < high:
        new = 0.5 * (low + high)
    return low, high, new, high - low <= ROUNDING * high
