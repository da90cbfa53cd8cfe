"""Exact Clopper-Pearson bounds of a pass rate (Biometrika 26, 1934).

The count is the number of draws that pass. The lower bound is the rate for which the observed count
or a larger count has the probability 1 - confidence. The bound is exact for independent draws.

The draws of a Latin hypercube are not independent. The mean of a function over n of these draws has
at most the variance of the mean over n - 1 independent draws (Owen, Annals of Statistics 25(4),
1997). The bounds are therefore computed for n - 1 independent draws with the observed pass rate.
Some hypercubes allow only every second count, if a failure depends on several factors jointly. The
lower bound is therefore computed for a count reduced by 0.5, except if every draw passes. The upper
bound is computed for a count increased by 0.5, except if every draw fails.
"""

from __future__ import annotations

import scipy

from frictool.campaign.draws.sampling import Method

CONFIDENCE = 0.95
STEP = 0.5  # correction of the count for a Latin hypercube


def lower(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> float:
    """Return the one-sided lower bound of the pass rate for `count` passes in `draws` trials."""
    weight = _independent(draws, method)
    if count == 0 or weight == 0.0:
        return 0.0
    passes = (count - STEP * (method == "latin" and count < draws)) / draws * weight
    return float(scipy.special.betaincinv(passes, weight - passes + 1.0, 1.0 - confidence))


def upper(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> float:
    """Return the one-sided upper bound of the pass rate for `count` passes in `draws` trials."""
    return 1.0 - lower(draws - count, draws, confidence, method)


def interval(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> tuple[float, float]:
    """Return the two-sided interval of the pass rate, with equal error probability on each side."""
    side = 0.5 * (1.0 + confidence)
    return lower(count, draws, side, method), upper(count, draws, side, method)


def draws_to_show(
    required: float, share: float, confidence: float = CONFIDENCE, method: Method = "random"
) -> int | None:
    """Return the smallest number of draws that shows the pass rate `required`.

    The fraction `share` of the draws is assumed to pass. The draws show the rate if the lower bound
    of the pass rate is at least `required`. Return None if `share` is not above `required`, or if
    more than 2^40 draws would be needed.
    """
    if not share > required:
        return None
    low, high = 1, 2
    while lower(_counted(share, high), high, confidence, method) < required:
        low = high
        high = 2 * high
        if high > 1 << 40:
            return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (
            (low, middle)
            if lower(_counted(share, middle), middle, confidence, method) >= required
            else (middle, high)
        )
    return high


def _counted(share: float, draws: int) -> int:
    return int(share * draws + 1e-9)


def _independent(draws: int, method: Method) -> float:
    """Return the number of independent draws that is equivalent to `draws` draws of a method."""
    return float(draws - 1) if method == "latin" else float(draws)
