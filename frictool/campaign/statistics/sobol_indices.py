"""First-order Sobol indices of the factors, estimated from the trials of the campaign.

    S_i = Var(E[Y | X_i]) / Var(Y)          Sobol, Math. Model. Comp. Exp. 1, 1993

Y is the metric and X_i the factor. E[Y | X_i] is estimated by the mean of Y in slices of X_i with
equal numbers of draws (Plischke, Borgonovo, Smith, European Journal of Operational Research 226,
2013). With n draws in k slices, chance alone gives the means a variance of (k - 1)/(n - k) times
the variance within the slices. This variance is subtracted, so that the estimate for a factor
without influence is 0 on average (Kelley's epsilon squared, PNAS 21, 1935).

The error of S_i is the root of the sum of two squares. The first term is the standard deviation of
the efficient estimator, which has the influence function 2 Y m - m^2 - S_i Y^2 with m = E[Y | X_i]
and zero-mean Y (Da Veiga and Gamboa, Journal of Nonparametric Statistics 25, 2013). The second term
is sqrt(2 (k - 1))/n, the error for a factor without influence.

The test of influence uses ranks. Infinite values are therefore allowed: a step that never settles
has the worst rank. Like Lepage's test for two samples (Biometrika 58, 1971), the test combines two
differences between the slices: in the mean rank (Kruskal and Wallis, JASA 47, 1952), and in the
spread of the ranks about the middle rank. The spread also reveals a factor that has no first-order
share because it acts only jointly with other factors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from frictool.campaign.statistics.slices import Slices
from frictool.typing import Vector

SLOPE = 0.1  # smallest rank correlation that is treated as rising or falling


@dataclass(frozen=True)
class VarianceShare:
    """Share of one factor in the variance of a metric.

    `share`, `error`: first-order Sobol index S_i of the factor, and the standard deviation of S_i.
    `of_ranks`, `error_of_ranks`: index and standard deviation for the ranks of the metric's values.
    `chance`: p-value of the rank test; None if the trials are not random.
    `rises`: rank correlation of metric and factor, -1 to 1.
    """

    share: float
    error: float
    of_ranks: float
    error_of_ranks: float
    chance: float | None
    rises: float

    @property
    def direction(self) -> str:
        """Return the change of the metric for a rising factor, such as "falls"."""
        return "rises" if self.rises > SLOPE else "falls" if self.rises < -SLOPE else "up and down"


def variance_share(slices: Slices, values: Vector, drawn: bool) -> tuple[float, float]:
    """Return the first-order Sobol index S_i for finite `values` (n,), and its standard deviation.

    If all vertices were simulated (`drawn` is False), S_i is exact and its standard deviation 0.
    """
    n, k = values.size, slices.count
    if k < 2 or (drawn and n <= k):
        return 0.0, 0.0
    largest = float(np.abs(values).max())
    # scaled, because squares of very large values overflow
    centred = values / largest if largest > 0.0 else values
    centred = centred - centred.mean()
    total = float(centred @ centred)
    if not total > n * 1e-24:
        return 0.0, 0.0
    means = slices.sums(centred) / slices.sizes
    between = float(slices.sizes @ means**2)
    if not drawn:
        return between / total, 0.0
    share = (between - (k - 1.0) * (total - between) / (n - k)) / total
    expected = means[slices.of]
    influence = (2.0 * centred * expected - expected**2 - share * centred**2) * n / total
    return share, float(np.sqrt(influence.var() / n + 2.0 * (k - 1.0) / n**2))


def scores_of(values: Vector) -> tuple[Vector, ...]:
    """Return the rank scores (location, spread) of `values` (n,), finite or infinite.

    Both scores have shape (n,) and zero mean, and are orthogonal. Equal values have equal ranks. If
    too many values are equal, the result contains only the first score, or none.
    """
    n = values.size
    score_of_rank = (scipy.stats.rankdata(values) - 0.5 * (n + 1.0)) / n
    scores: list[Vector] = []
    for score in (score_of_rank, score_of_rank**2):
        score = score - score.mean()
        for other in scores:  # if values are equal, the scores are not orthogonal yet
            score = score - (score @ other) / (other @ other) * other
        if float(score @ score) > 1e-9 * n:
            scores.append(score)
    return tuple(scores)


def chance_of_ranks(slices: Slices, scores: tuple[Vector, ...]) -> float:
    """Return the p-value of the differences between the mean scores of the slices."""
    n = slices.of.size
    k = slices.count
    if n <= k or k < 2 or not scores:
        return 1.0
    statistic = sum(
        (n - 1.0) * float((slices.sums(score) ** 2 / slices.sizes).sum()) / float(score @ score)
        for score in scores
    )
    return float(scipy.special.gammaincc(0.5 * (k - 1.0) * len(scores), 0.5 * statistic))


def rank_correlation(units: Vector, scores: tuple[Vector, ...]) -> float:
    """Return the rank correlation, -1 to 1, of the draws `units` (n,) and the metric's values.

    `scores`: rank scores of the metric's values (`scores_of`). The draws, uniform in [0, 1], are
    used instead of their ranks. Returns 0 if the draws or the values do not vary.
    """
    if not scores:
        return 0.0
    centred = units - units.mean()
    norm = float(np.sqrt((centred @ centred) * (scores[0] @ scores[0])))
    return float(centred @ scores[0]) / norm if norm > 0.0 else 0.0
