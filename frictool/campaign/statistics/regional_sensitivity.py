"""Regional sensitivity: differences between failing and passing trials along each factor.

The method of Hornberger and Spear (Journal of Environmental Management 12, 1981) compares two
distributions of each factor: in the failing and in the passing trials. It computes their
Kolmogorov-Smirnov distance, and the p-value of this distance. The p-value is valid for random draws
and for a Latin hypercube.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.campaign.statistics.slices import Slices
from frictool.typing import BoolVector, Vector

# largest product of the numbers of failing and of passing trials for an exact p-value; for a larger
# product the p-value is asymptotic
EXACT = 4_000_000


@dataclass(frozen=True)
class FailureRegion:
    """Comparison of failing and passing trials along one factor.

    `distance`: Kolmogorov-Smirnov distance of the factor's distributions in failing and passing
        trials, 0 to 1.
    `chance`: p-value of the distance; None if the trials are not random.
    `leans`: Pr(f > p) - Pr(f < p), -1 to 1, for the factor's value f in a failing trial and p in a
        passing trial.
    `spread`: Pr(|f - c| > |p - c|) - Pr(|f - c| < |p - c|) for the middle c of the range.
    `noise`: standard deviation of `leans` and `spread` for a factor without influence.
    `failing` (k,): share of failing trials in each of k slices of the range.
    `sizes` (k,): number of trials in each slice.
    `centres` (k,): mean factor value in each slice, in SI.
    """

    distance: float
    chance: float | None
    leans: float
    spread: float
    noise: float
    failing: Vector
    sizes: NDArray[np.int64]
    centres: Vector

    @property
    def direction(self) -> str:
        """Return the part of the factor's range in which most failures lie, such as "high"."""
        least = 2.0 * self.noise
        if abs(self.leans) > least and abs(self.leans) >= 0.5 * abs(self.spread):
            return "high" if self.leans > 0.0 else "low"
        if abs(self.spread) > least:
            return "both ends" if self.spread > 0.0 else "the middle"
        return "no one place"


def region(
    units: Vector, values: Vector, failing: BoolVector, slices: Slices, drawn: bool
) -> FailureRegion:
    """Compare failing and passing trials along a factor.

    `units` (n,): value of the factor in each draw, scaled to 0 to 1.
    `values` (n,): value of the factor in each draw, in SI.
    `failing` (n,): mask of failing trials.

    Raises ValueError if no trial fails, or if all fail.
    """
    bad = units[failing]
    good = units[~failing]
    if bad.size == 0 or good.size == 0:
        raise ValueError("a comparison needs failing and passing trials")
    distance, chance = _smirnov(bad, good)
    sizes = slices.sizes
    return FailureRegion(
        distance,
        chance if drawn else None,
        _leaning(bad, good),
        _leaning(np.abs(bad - 0.5), np.abs(good - 0.5)),
        np.sqrt((failing.size + 1.0) / (3.0 * bad.size * good.size)) if drawn else 0.0,
        slices.sums(failing.astype(float)) / sizes,
        sizes,
        slices.sums(values) / sizes,
    )


def _smirnov(bad: Vector, good: Vector) -> tuple[float, float]:
    """Return the Kolmogorov-Smirnov distance and its p-value.

    The p-value is exact for few trials. For many trials (n failing, m passing), it is the p-value
    of the one-sample test with n m/(n + m) draws.
    """
    method = "exact" if bad.size * good.size <= EXACT else "asymp"
    if method == "exact":
        test = scipy.stats.ks_2samp(bad, good, method=method)
        return float(test.statistic), float(test.pvalue)
    distance = float(scipy.stats.ks_2samp(bad, good, method="asymp").statistic)
    return distance, float(
        scipy.stats.kstwo.sf(distance, max(1, int(bad.size * good.size / (bad.size + good.size))))
    )


def _leaning(bad: Vector, good: Vector) -> float:
    """Return Pr(bad > good) - Pr(bad < good), from the Mann-Whitney statistic."""
    ordered = np.sort(good)
    below = np.searchsorted(ordered, bad, side="left").sum()
    above = good.size - np.searchsorted(ordered, bad, side="right")
    return float(below - above.sum()) / (bad.size * good.size)
