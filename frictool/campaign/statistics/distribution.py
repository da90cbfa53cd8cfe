"""Distribution of a metric in the trials: quantiles with intervals, tolerance bound, histogram.

All statistics are order statistics, which assume no form of the distribution. At least the share
beta of all plants has a value of at most the r-th of n sorted values. This holds with confidence
gamma if P(Binomial(n, beta) <= r - 1) >= gamma (Wilks, Annals of Mathematical Statistics 12, 1941).
The largest such beta is the Clopper-Pearson lower bound for the count r (clopper_pearson.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import CONFIDENCE, lower
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, MetricLimit, Trials
from frictool.presentation.tie_rule import largest, smallest
from frictool.typing import IntVector, Vector

QUANTILES = (0.05, 0.5, 0.95)
COVERED = 0.95  # share of all plants within the tolerance bound
BINS = 40  # number of histogram bins
# least number of values for a histogram without outliers; least distance of an outlier from the
# middle 90 % of the values, relative to the range of these 90 %
MANY = 100
FAR = 1.5


@dataclass(frozen=True)
class Quantile:
    """Quantile of a metric: the share `level` of all plants has at most the value `value`.

    `low`, `high`: confidence interval of the quantile; infinite if there are too few draws, None if
        the trials are not random.
    """

    level: float
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Histogram:
    """Histogram of finite values: edges (k + 1,) and counts (k,); both are empty without values.

    If the metric's limit lies between the smallest and the largest value, the limit is an edge.

    `outside`: number of finite outliers, which are in no bin.
    """

    edges: Vector
    counts: IntVector
    outside: int = 0


@dataclass(frozen=True)
class Distribution:
    """Distribution of one metric in the trials.

    `met`, `broken`, `undecided`: numbers of trials with this outcome of the requirement.
    `beyond`: number of trials with an infinite value.
    `missing`: number of trials without a value, including trials that could not be simulated.
    `bound`: tolerance bound. With the requested confidence, at least the share COVERED of all
        plants is within this bound. None if there are too few trials or no finite bound.
    `trials_for_bound`: smallest number of trials for which a bound exists.
    `worst`: worst value, infinite if any value is infinite.
    `worst_trial`: first draw with the worst value.
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
        """Return True if the metric has a finite value in any trial."""
        return self.histogram.counts.size > 0

    @property
    def varies(self) -> bool:
        """Return True if the metric's finite values differ between trials."""
        return self.histogram.counts.size > 1


def distribution(
    trials: Trials, index: int, method: Method, confidence: float = CONFIDENCE
) -> Distribution:
    """Return the distribution of the metric `index`."""
    metric = trials.metrics[index]
    values = trials.metric_values[:, index]
    met = trials.met[:, index]
    finite = np.isfinite(values)
    known = ~np.isnan(values)
    upward = metric.relation == "<="
    worst, worst_trial = (largest if upward else smallest)(values) if known.any() else (None, None)
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
        quantiles=_quantiles(np.sort(values[known]), None if whole else method, confidence),
        bound=None if whole else _bound(values, upward, method, confidence),
        trials_for_bound=fewest(method, confidence),
        worst=worst,
        worst_trial=worst_trial,
        histogram=_histogram(values[finite], metric),
    )


def fewest(method: Method, confidence: float = CONFIDENCE) -> int:
    """Return the smallest number of draws whose worst value is a tolerance bound."""
    return _first(lambda n: lower(n, n, confidence, method) >= COVERED, 1, 1 << 20)


def rank(draws: int, level: float, confidence: float, method: Method) -> int | None:
    """Return the smallest rank r whose value bounds the share `level` of all plants.

    The r-th smallest of the `draws` values is an upper bound for this share, with `confidence`.
    Return None if there are too few draws.
    """
    if draws == 0 or lower(draws, draws, confidence, method) < level:
        return None
    return _first(lambda r: lower(r, draws, confidence, method) >= level, 1, draws)


def _first(holds: Callable[[int], bool], low: int, high: int) -> int:
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle + 1, high)
    return low


def _bound(values: Vector, upward: bool, method: Method, confidence: float) -> float | None:
    """Return the tolerance bound; a trial without a value is treated as an infinite value."""
    worst_last = np.sort(np.where(np.isnan(values), np.inf, values if upward else -values))
    order = rank(values.size, COVERED, confidence, method)
    if order is None or not np.isfinite(worst_last[order - 1]):
        return None
    return float(worst_last[order - 1] if upward else -worst_last[order - 1])


def _quantiles(ordered: Vector, method: Method | None, confidence: float) -> tuple[Quantile, ...]:
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
    below = rank(n, 1.0 - level, side, method)  # the same rank, counted from above
    low = float(ordered[n - below]) if below is not None else -np.inf
    return Quantile(level, value, low, float(ordered[above - 1]) if above is not None else np.inf)


def _histogram(values: Vector, metric: MetricLimit) -> Histogram:
    """Return a histogram with equal bins.

    The limit is an edge between two bins, except if it is far from the values. A value equal to the
    limit belongs to the bin whose values meet the requirement.
    """
    if values.size == 0:
        return Histogram(np.empty(0), np.empty(0, dtype=np.int64))
    limit = metric.limit
    low, high = _reach(values, limit)
    near = values[(values >= low) & (values <= high)]
    width = (high - low) / BINS
    if not width > 1e-12 * max(abs(low), abs(high)):  # a single value gets one bin around it
        around = max(abs(low), 1e-300) / BINS
        return Histogram(np.array([low - around, high + around]), np.array([near.size]))
    origin = limit if low - width < limit < high + width else low
    below, above = int(np.ceil((origin - low) / width)), int(np.ceil((high - origin) / width))
    # bins (a, b] for an upper limit, [a, b) for a lower limit
    side: Literal["left", "right"] = "left" if metric.relation == "<=" else "right"
    below += side == "left" and origin - below * width >= low
    above += side == "right" and origin + above * width <= high
    edges: Vector = np.asarray(origin + width * np.arange(-below, above + 1.0), dtype=float)
    bins = np.clip(np.searchsorted(edges, near, side=side) - 1, 0, edges.size - 2)
    return Histogram(edges, np.bincount(bins, minlength=edges.size - 1), values.size - near.size)


def _reach(values: Vector, limit: float) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    fifth, last = (float(q) for q in np.quantile(values, (0.05, 0.95)))
    body = last - fifth
    # the second condition is True if nearly all values are equal
    if values.size < MANY or not body > 1e-6 * (high - low):
        return low, high
    near = fifth - FAR * body
    far = last + FAR * body
    if low <= limit <= high:
        near = min(near, limit - body)
        far = max(far, limit + body)
    return max(low, near), min(high, far)
