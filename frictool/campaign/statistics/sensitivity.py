"""Which factors the failures come from, and which the values of each metric: tables for text, page
and machine.

    Trials ──slices.py──▶ regional_sensitivity.py: fails against passes ────────┐
                    └───▶ sobol_indices.py: metric by metric ─────┴─holm_correction.py──▶
                    Sensitivity

Of vertices that were all played nothing is random, so that shares are exact and have no
probability.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.statistics.holm_correction import holm_corrected
from frictool.campaign.statistics.interaction import joint_share
from frictool.campaign.statistics.regional_sensitivity import FailureRegion, region
from frictool.campaign.statistics.simplex_projection import within_whole
from frictool.campaign.statistics.slices import TENTHS, SortedDraws, few_slices_for, slices_for
from frictool.campaign.statistics.sobol_indices import (
    VarianceShare,
    chance_of_ranks,
    rank_correlation,
    scores_of,
    variance_share,
)
from frictool.campaign.trials.trials import BROKEN, MET, Trials
from frictool.presentation.ties import largest

Mask = NDArray[np.bool_]
LEVEL = 0.05  # of a table: the probability that it names a factor without influence
LEAST_DISTANCE, LEAST_SHARE = (
    0.1,
    0.01,
)  # below which vertices, of which nothing is random, say no influence
FEWEST = 20  # trials with a value, below which no influence is estimated
# of the variance of the ranks, by which it has to be more than that of the values to be told too
HIDDEN = 0.1
FINEST = 12  # slices a factor of a plane


@dataclass(frozen=True)
class FailureComparison:
    """Trials that fail against those that pass. name: of the requirement that is broken, or "" for
    any, "not simulated" for those that failed.

    regions (d,): of each factor, the chances corrected for all questions of the table; order: the
    factors, the clearest first.
    """

    name: str
    failing: int
    passing: int
    regions: tuple[FailureRegion, ...]

    @property
    def order(self) -> tuple[int, ...]:
        """The factors, the clearest first."""
        return tuple(
            sorted(
                range(len(self.regions)),
                key=lambda i: (self.regions[i].chance or 0.0, -self.regions[i].distance),
            )
        )

    @property
    def named(self) -> tuple[int, ...]:
        """The factors that the failures come from, the clearest first."""
        return tuple(
            i
            for i in self.order
            if _believed(self.regions[i].chance, self.regions[i].distance > LEAST_DISTANCE)
        )


@dataclass(frozen=True)
class MetricInfluence:
    """On one metric. shares (d,): of each factor; used: trials with a finite value; reason: why
    there are no shares."""

    used: int
    shares: tuple[VarianceShare, ...] = ()
    reason: str = ""

    @property
    def rest(self) -> float | None:
        """Of the variance what no named factor explains by itself: factors that act together,
        noise, what slices are too coarse for."""
        return (
            max(0.0, 1.0 - sum(max(0.0, self.shares[i].share) for i in self.named))
            if self.shares
            else None
        )

    @property
    def rest_of_ranks(self) -> float | None:
        """The same of the ranks."""
        return (
            max(0.0, 1.0 - sum(max(0.0, self.shares[i].of_ranks) for i in self.named))
            if self.shares
            else None
        )

    @property
    def by_rank(self) -> bool:
        """Whether ranks tell of a named factor what values hide, of which a few are enormous, or
        beyond any."""
        return any(self.shares[i].of_ranks - self.shares[i].share > HIDDEN for i in self.named)

    @property
    def order(self) -> tuple[int, ...]:
        """The factors, the largest share first."""
        return tuple(sorted(range(len(self.shares)), key=lambda i: -self.shares[i].share))

    @property
    def named(self) -> tuple[int, ...]:
        """The factors with an influence, the largest share first."""
        return tuple(
            i
            for i in self.order
            if _believed(self.shares[i].chance, self.shares[i].share > LEAST_SHARE)
        )


@dataclass(frozen=True)
class FactorPair:
    """The two factors that explain the failures best. joint: their share of the variance of pass or
    fail; beyond: what neither has alone.

    error: of beyond, one standard deviation where there is nothing beyond.
    """

    first: int
    second: int
    joint: float
    beyond: float
    error: float


@dataclass(frozen=True)
class Sensitivity:
    """questions: any failure first, then each requirement; influences (m,): of the metrics; pair:
    None without failures or a second factor.
    """

    questions: tuple[FailureComparison, ...]
    influences: tuple[MetricInfluence, ...]
    pair: FactorPair | None


def sensitivity(trials: Trials, drawn: bool) -> Sensitivity:
    """Of the trials. drawn: whether they were drawn at random, and are not all vertices."""
    draws = SortedDraws(trials)
    questions, influences = _questions(trials, draws, drawn), _influences(trials, draws, drawn)
    return Sensitivity(
        questions,
        influences,
        _pair(trials, draws, drawn) if questions and questions[0].name == "" else None,
    )


def masks(trials: Trials) -> list[tuple[str, Mask, Mask]]:
    """Name, failing and passing trials of each question that can be asked; one that repeats another
    is left out."""
    asked = [("", trials.passed == BROKEN, trials.passed == MET)]
    asked += [
        (metric.name, trials.met[:, j] == BROKEN, trials.met[:, j] == MET)
        for j, metric in enumerate(trials.metrics)
    ]
    not_run = np.isin(np.arange(trials.count), list(trials.failed))
    asked.append(("not simulated", not_run, ~not_run))
    kept: list[tuple[str, Mask, Mask]] = []
    for name, failing, passing in asked:
        same = any(
            np.array_equal(failing, other) and np.array_equal(passing, good)
            for _, other, good in kept
        )
        if failing.any() and passing.any() and not same:
            kept.append((name, failing, passing))
    return kept


def _believed(chance: float | None, large: bool) -> bool:
    return large if chance is None else chance <= LEVEL


def _questions(trials: Trials, draws: SortedDraws, drawn: bool) -> tuple[FailureComparison, ...]:
    asked = masks(trials)
    regions: list[FailureRegion] = []
    for _, failing, passing in asked:
        chosen = failing | passing
        for factor in range(trials.space.size):
            slices = draws.sliced(factor, TENTHS, chosen)
            regions.append(
                region(
                    trials.units[chosen, factor],
                    trials.values[chosen, factor],
                    failing[chosen],
                    slices,
                    drawn,
                )
            )
    if drawn and regions:
        chances = holm_corrected(np.array([one.chance for one in regions]))
        regions = [
            dataclasses.replace(one, chance=float(chance))
            for one, chance in zip(regions, chances, strict=True)
        ]
    d = trials.space.size
    return tuple(
        FailureComparison(
            name, int(failing.sum()), int(passing.sum()), tuple(regions[k * d : (k + 1) * d])
        )
        for k, (name, failing, passing) in enumerate(asked)
    )


def _influences(trials: Trials, draws: SortedDraws, drawn: bool) -> tuple[MetricInfluence, ...]:
    found = [_influence(trials, draws, j, drawn) for j in range(len(trials.metrics))]
    shares = [share for influence in found for share in influence.shares]
    if not drawn or not shares:
        return tuple(found)
    chances = iter(holm_corrected(np.array([share.chance for share in shares])))
    return tuple(
        _adding_up(
            dataclasses.replace(
                one,
                shares=tuple(
                    dataclasses.replace(share, chance=float(next(chances))) for share in one.shares
                ),
            )
        )
        for one in found
    )


def _adding_up(one: MetricInfluence) -> MetricInfluence:
    """With the shares of the factors that are named as parts of one whole."""
    named, shares = list(one.named), list(one.shares)
    values = within_whole(
        np.array([shares[i].share for i in named]), np.array([shares[i].error for i in named])
    )
    ranks = within_whole(
        np.array([shares[i].of_ranks for i in named]),
        np.array([shares[i].error_of_ranks for i in named]),
    )
    for i, share, of_ranks in zip(named, values, ranks, strict=True):
        shares[i] = dataclasses.replace(shares[i], share=float(share), of_ranks=float(of_ranks))
    return dataclasses.replace(one, shares=tuple(shares))


def _influence(trials: Trials, draws: SortedDraws, metric: int, drawn: bool) -> MetricInfluence:
    values = trials.found[:, metric]
    known, finite = ~np.isnan(values), np.isfinite(values)
    told, used = int(known.sum()), int(finite.sum())
    if told == 0:
        return MetricInfluence(used, reason="no trial has a value")
    if told < FEWEST and drawn:
        return MetricInfluence(used, reason=f"{told} trials have a value, {FEWEST} are needed")
    scores = scores_of(values[known])
    if not scores:
        return MetricInfluence(used, reason="it is the same in every trial")
    shares = []
    for factor in range(trials.space.size):
        ranked = draws.sliced(factor, slices_for(told), known)
        slices = ranked if used == told else draws.sliced(factor, slices_for(used), finite)
        few = draws.sliced(factor, few_slices_for(told), known)
        share, error = variance_share(slices, values[finite], drawn)
        of_ranks = variance_share(ranked, scores[0], drawn)
        chance = chance_of_ranks(few, scores) if drawn else None
        shares.append(
            VarianceShare(
                share,
                error,
                *of_ranks,
                chance,
                rank_correlation(trials.units[known, factor], scores),
            )
        )
    return MetricInfluence(used, tuple(shares))


def _pair(trials: Trials, draws: SortedDraws, drawn: bool) -> FactorPair | None:
    """The pair whose plane separates failing from passing trials best."""
    decided = trials.passed != -1
    failing = (trials.passed[decided] == BROKEN).astype(float)
    n = failing.size
    each = int(np.clip(round(n**0.25), 2, FINEST))
    slices = [draws.sliced(factor, each, decided) for factor in range(trials.space.size)]
    pairs = [
        FactorPair(i, j, *joint_share(slices[i], slices[j], failing, drawn))
        for i, j in combinations(range(trials.space.size), 2)
    ]
    return pairs[largest(pair.joint for pair in pairs)[1]] if pairs else None
