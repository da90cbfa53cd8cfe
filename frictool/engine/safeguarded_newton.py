"""A root in a bracket that shrinks from both sides: Newton's step where it stays inside, else the
middle."""

from __future__ import annotations

from frictool.runtime.kernels import inner_kernel

ROUNDING = 2.0**-52
MAX_ITERATIONS = 200  # bisection alone needs 60-110; reached by no bracket of finite numbers


@inner_kernel
def bracket_step(
    t: float, ahead: float, slope: float, low: float, high: float
) -> tuple[float, float, float, bool]:
    """One step for a function that falls from low to high and is `ahead` at t with `slope`: low,
    high, the next t, whether that is it."""
    if ahead > 0.0:
        low = t
    else:
        high = t
    new = t - ahead / slope if slope < 0.0 else low
    if ahead == 0.0 or (slope < 0.0 and abs(new - t) <= ROUNDING * t):
        return (
            low,
            high,
            t,
            True,
        )  # t is now an end of the bracket, so that the step need not lie inside
    if not low < new < high:
        new = 0.5 * (low + high)
    return low, high, new, high - low <= ROUNDING * high
