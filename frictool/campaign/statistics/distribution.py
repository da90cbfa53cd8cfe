"""How a metric is distributed over the trials: quantiles with their intervals, a bound that a share
of all plants keeps, a histogram.

All from order statistics, so that no form of the distribution is assumed: the r-th of n sorted
values has at least the share beta of all plants below it with the confidence gamma where
P(Binomial(n, beta) <= r - 1) >= gamma (Wilks, Annals of Mathematical Statistics 12, 1941), and that
is Clopper and Pearson's lower bound of the count r (clopper_pearson.py). 59 draws are the fewest of
which the largest is such a bound for 95 % with 95 %.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, lower
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, MetricLimit, Trials
from frictool.presentation.ties import largest, smallest

Vector = NDArray[np.float64]
Counts = NDArray[np.int64]
QUANTILES = (0.05, 0.5, 0.95)
COVERED = 0.95  # of all plants, by the bound
BINS = 40  # of a histogram
MANY, FAR = 100, 1.5  # values, from which on bins reach so many widths of the middle 90 % beyond it


@dataclass(frozen=True)
class Quantile:
    """The value that a share `level` of the plants is at most; inf where that is beyond any. low,
    high: with the confidence, inf where unknown.
    """

    level: float
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Histogram:
    """edges (k + 1,) and counts (k,) of finite values; one edge is the limit where it lies among
    them. Both empty where there is none.

    outside: finite values too far from the others to be in a bin.
    """

    edges: Vector
    counts: Counts
    outside: int = 0


@dataclass(frozen=True)
class Distribution:
    """Of one metric.

    met, broken, undecided: trials; beyond: of those, the ones whose value is beyond any; missing:
    without a value, those not simulated included. bound: what COVERED of all plants keep with the
    confidence (None where too few trials, or more than that share have no finite value);
    trials_for_bound: how many trials give one at least. worst: the worst value, inf where one is
    beyond any; worst_trial: the first draw that has it.
    """

    metric: MetricLimit
    met: int
    broken: int
    undecided: int
    beyond: int
    missing: int
    quantiles: tuple[Quantile, ...]
    bound: float | None
    trials_for_bound: int
    worst: float | None
    worst_trial: int | None
    histogram: Histogram

    @property
    def has_values(self) -> bool:
        """Whether any trial has given a finite value."""
        return self.histogram.counts.size > 0

    @property
    def varies(self) -> bool:
        """Whether trials differ in their finite values."""
        return self.histogram.counts.size > 1


def distribution(
    trials: Trials, index: int, method: Method, confidence: float = CONFIDENCE
) -> Distribution:
    """Of the metric number `index`."""
    metric, found, met = trials.metrics[index], trials.found[:, index], trials.met[:, index]
    finite, known = np.isfinite(found), ~np.isnan(found)
    upward = metric.relation == "<="
    worst, worst_trial = (largest if upward else smallest)(found) if known.any() else (None, None)
    whole = method == "vertices"
    passed, broken, undecided = (
        int(np.count_nonzero(met == mark)) for mark in (MET, BROKEN, UNDECIDED)
    )
    return Distribution(
        metric,
        passed,
        broken,
        undecided,
        beyond=int(np.count_nonzero(known & ~finite)),
        missing=int(np.count_nonzero(~known)),
        quantiles=_quantiles(np.sort(found[known]), None if whole else method, confidence),
        bound=None if whole else _bound(found, upward, method, confidence),
        trials_for_bound=fewest(method, confidence),
        worst=worst,
        worst_trial=worst_trial,
        histogram=_histogram(found[finite], metric),
    )


def fewest(method: Method, confidence: float = CONFIDENCE) -> int:
    """The fewest draws whose largest value COVERED of all plants keep."""
    return _first(lambda n: lower(n, n, confidence, method) >= COVERED, 1, 1 << 20)


def rank(draws: int, level: float, confidence: float, method: Method) -> int | None:
    """The least r with which the r-th smallest of the draws has the share `level` of all plants
    below it; None of too few draws."""
    if draws == 0 or lower(draws, draws, confidence, method) < level:
        return None
    return _first(lambda r: lower(r, draws, confidence, method) >= level, 1, draws)


def _first(holds: Callable[[int], bool], low: int, high: int) -> int:
    """The first whole number of low..high from which on `holds` does."""
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _bound(found: Vector, upward: bool, method: Method, confidence: float) -> float | None:
    """The r-th value, counted from the good side; a trial without a value is taken as the worst
    there can be."""
    worst_last = np.sort(np.where(np.isnan(found), np.inf, found if upward else -found))
    place = rank(found.size, COVERED, confidence, method)
    if place is None or not np.isfinite(worst_last[place - 1]):
        return None
    return float(worst_last[place - 1] if upward else -worst_last[place - 1])


def _quantiles(ordered: Vector, method: Method | None, confidence: float) -> tuple[Quantile, ...]:
    """Of sorted values (n,); without a method, no interval."""
    return (
        tuple(_quantile(ordered, level, method, confidence) for level in QUANTILES)
        if ordered.size
        else ()
    )


def _quantile(ordered: Vector, level: float, method: Method | None, confidence: float) -> Quantile:
    n = ordered.size
    value = float(ordered[max(0, int(np.ceil(level * n)) - 1)])
    if method is None:
        return Quantile(level, value, None, None)
    side = 0.5 * (1.0 + confidence)
    above = rank(n, level, side, method)
    below = rank(n, 1.0 - level, side, method)  # the same, counted from above
    low = float(ordered[n - below]) if below is not None else -np.inf
    return Quantile(level, value, low, float(ordered[above - 1]) if above is not None else np.inf)


def _histogram(values: Vector, metric: MetricLimit) -> Histogram:
    """Bins of one width; where the limit is near the values it is an edge, and a value at the limit
    lies on the side that meets it."""
    if values.size == 0:
        return Histogram(np.empty(0), np.empty(0, dtype=np.int64))
    limit = metric.limit
    low, high = _reach(values, limit)
    near = values[(values >= low) & (values <= high)]
    width = (high - low) / BINS
    if not width > 1e-12 * max(abs(low), abs(high)):  # one value: a bin around it
        around = max(abs(low), 1e-300) / BINS
        return Histogram(np.array([low - around, high + around]), np.array([near.size]))
    origin = limit if low - width < limit < high + width else low
    below, above = int(np.ceil((origin - low) / width)), int(np.ceil((high - origin) / width))
    side: Literal["left", "right"] = (
        "left" if metric.relation == "<=" else "right"
    )  # bins (a, b] or [a, b)
    below += side == "left" and origin - below * width >= low
    above += side == "right" and origin + above * width <= high
    edges: Vector = np.asarray(origin + width * np.arange(-below, above + 1.0), dtype=float)
    places = np.clip(np.searchsorted(edges, near, side=side) - 1, 0, edges.size - 2)
    return Histogram(edges, np.bincount(places, minlength=edges.size - 1), values.size - near.size)


def _reach(values: Vector, limit: float) -> tuple[float, float]:
    """Between which values there are bins: not so far that a few of many make all the others one
    bar, but beyond the limit where values are.
    """
    low, high = float(values.min()), float(values.max())
    fifth, last = (float(q) for q in np.quantile(values, (0.05, 0.95)))
    body = last - fifth
    if values.size < MANY or not body > 1e-6 * (high - low):  # nearly all are one value
        return low, high
    near, far = fifth - FAR * body, last + FAR * body
    if low <= limit <= high:
        near, far = min(near, limit - body), max(far, limit + body)
    return max(low, near), min(high, far)
