"""Which factor the variance of a metric comes from: first-order Sobol indices of the trials that
are there, no further ones needed.

    S_i = Var(E[Y | X_i]) / Var(Y)                                              Sobol, Math. Model.
                                                                                Comp. Exp. 1, 1993

E[Y | X_i] is the mean of Y in slices of X_i of equal counts (the correlation ratio; Plischke,
Borgonovo, Smith, European Journal of Operational Research 226, 2013). What the means of k slices
vary by chance, (k - 1)/(n - k) of the variance inside of them, is taken off, so that a factor
without influence has 0 on average (Kelley's epsilon squared, PNAS 21, 1935). Its error is that of
the efficient estimator, whose influence function is 2 Y m - m^2 - S Y^2 with m = E[Y | X_i] and Y
of mean 0 (Da Veiga and Gamboa, Journal of Nonparametric Statistics 25, 2013), and, where there is
no influence, that of the means' chance, sqrt(2 (k - 1))/n.

Whether there is an influence at all is decided by ranks, so that neither a few enormous values nor
those that are beyond any (a step that never settles is the worst rank) upset it: the probability
that over the slices their means (Kruskal and Wallis, JASA 47, 1952) and their spread about the
middle differ as much by chance (both together as Lepage, Biometrika 58, 1971, for two samples). A
factor that acts only together with others has no share of its own, and is found by the spread.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc
from scipy.stats import rankdata

from frictool.campaign.statistics.slices import Slices

Vector = NDArray[np.float64]
SLOPE = 0.1  # a rank correlation beyond it says up or down


@dataclass(frozen=True)
class VarianceShare:
    """share: S_i; error: its standard deviation; of_ranks, error_of_ranks: the same of the values'
    ranks, those beyond any included; chance: that ranks differ as much without an influence, None
    where nothing is random.

    rises: the rank correlation of the metric with the factor, -1..1.
    """

    share: float
    error: float
    of_ranks: float
    error_of_ranks: float
    chance: float | None
    rises: float

    @property
    def direction(self) -> str:
        """What the metric does where the factor grows."""
        return "rises" if self.rises > SLOPE else "falls" if self.rises < -SLOPE else "up and down"


def variance_share(slices: Slices, values: Vector, drawn: bool) -> tuple[float, float]:
    """S_i of finite values (n,), and its error; of vertices that were all played (not drawn),
    without a correction and without an error."""
    n, k = values.size, slices.count
    if k < 2 or (drawn and n <= k):
        return 0.0, 0.0
    largest = float(np.abs(values).max())
    centred = (
        values / largest if largest > 0.0 else values
    )  # a share has no unit, and squares of what is enormous no value
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
    """What of the ranks of values (n,), which may be inf, is compared: place and spread, each (n,)
    of mean 0, orthogonal; equal values share ranks.

    One or none where too many values are equal to tell more.
    """
    n = values.size
    place = (rankdata(values) - 0.5 * (n + 1.0)) / n
    scores: list[Vector] = []
    for score in (place, place**2):
        score = score - score.mean()
        for other in scores:  # of tied values the two are not independent by themselves
            score = score - (score @ other) / (other @ other) * other
        if float(score @ score) > 1e-9 * n:
            scores.append(score)
    return tuple(scores)


def chance_of_ranks(slices: Slices, scores: tuple[Vector, ...]) -> float:
    """That the scores (scores_of) differ as much between the slices by chance."""
    n, k = slices.of.size, slices.count
    if n <= k or k < 2 or not scores:
        return 1.0
    statistic = sum(
        (n - 1.0) * float((slices.sums(score) ** 2 / slices.sizes).sum()) / float(score @ score)
        for score in scores
    )
    return float(gammaincc(0.5 * (k - 1.0) * len(scores), 0.5 * statistic))


def rank_correlation(units: Vector, scores: tuple[Vector, ...]) -> float:
    """-1..1, of the place of draws (n,) in 0..1, which is as good as their rank, with the rank of
    the values whose scores (scores_of) these are.

    0 where one of the two does not vary.
    """
    if not scores:
        return 0.0
    place = units - units.mean()
    norm = float(np.sqrt((place @ place) * (scores[0] @ scores[0])))
    return float(place @ scores[0]) / norm if norm > 0.0 else 0.0
