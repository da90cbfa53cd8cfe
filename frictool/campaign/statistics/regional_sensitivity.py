"""Which factor the failures come from: whether the trials that fail lie elsewhere on its range than
those that pass.

Regional sensitivity analysis (Hornberger and Spear, Journal of Environmental Management 12, 1981):
the largest distance between the distribution of the factor over the failing trials and over the
passing ones, with the probability that it is as large by chance (Kolmogorov and Smirnov). Under no
influence every assignment of the failures to the draws is as likely, of random draws and of a Latin
hypercube, so that the test holds for both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ks_2samp, kstwo

from frictool.campaign.statistics.slices import Slices

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]
# failing times passing trials up to which the probability is counted and not taken from the limit
EXACT = 4_000_000


@dataclass(frozen=True)
class FailureRegion:
    """Of one factor. distance: of the two distributions, 0..1; chance: that it is as large without
    an influence; None where nothing is random.

    leans: how much more likely a failing trial lies above a passing one than below, -1..1. spread:
    the same of the distance from the middle; noise: the standard deviation of either by chance.
    failing (k,): the share that fails in each slice of its range, of sizes (k,) trials; places
    (k,): their means, in SI.
    """

    distance: float
    chance: float | None
    leans: float
    spread: float
    noise: float
    failing: Vector
    sizes: NDArray[np.int64]
    places: Vector

    @property
    def direction(self) -> str:
        """Where on the range the failures are."""
        least = 2.0 * self.noise
        if abs(self.leans) > least and abs(self.leans) >= 0.5 * abs(self.spread):
            return "high" if self.leans > 0.0 else "low"
        if abs(self.spread) > least:
            return "both ends" if self.spread > 0.0 else "the middle"
        return "no one place"


def region(
    units: Vector, values: Vector, failing: Mask, slices: Slices, drawn: bool
) -> FailureRegion:
    """Of a factor's draws (n,) in 0..1, `values` in SI, of which `failing` (n,) fail.

    Raises ValueError where none fails, or none passes.
    """
    bad, good = units[failing], units[~failing]
    if bad.size == 0 or good.size == 0:
        raise ValueError("a comparison needs trials that fail and trials that pass")
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
    """The distance and its probability: counted, or that of one sample of n m/(n + m) draws where
    there are many."""
    method = "exact" if bad.size * good.size <= EXACT else "asymp"
    if method == "exact":
        found = ks_2samp(bad, good, method=method)
        return float(found.statistic), float(found.pvalue)
    distance = float(ks_2samp(bad, good, method="asymp").statistic)
    return distance, float(
        kstwo.sf(distance, max(1, int(bad.size * good.size / (bad.size + good.size))))
    )


def _leaning(bad: Vector, good: Vector) -> float:
    """P(bad > good) - P(bad < good), from Mann and Whitney's count."""
    ordered = np.sort(good)
    below = np.searchsorted(ordered, bad, side="left").sum()
    above = good.size - np.searchsorted(ordered, bad, side="right")
    return float(below - above.sum()) / (bad.size * good.size)
