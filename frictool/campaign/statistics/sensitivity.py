"""Sensitivity of failures and metrics to the factors.

    failures: Trials ──slices.py──▶ regional_sensitivity.py ──holm_correction.py──▶ Sensitivity
    metrics:  Trials ──slices.py──▶ sobol_indices.py        ──holm_correction.py──▶ Sensitivity

If all vertices were simulated, nothing is random: shares are exact and have no p-value.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import combinations

import numpy as np

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
from frictool.presentation.tie_rule import largest
from frictool.typing import BoolVector

LEVEL = 0.05  # probability that a table names a factor without influence
# least distance and least share of a significant factor if all vertices were simulated
LEAST_DISTANCE, LEAST_SHARE = 0.1, 0.01
FEWEST = 20  # smallest number of trials with a value for an estimate of influence
# the variance share of the ranks is reported if it exceeds the variance share of the values by this
# number
HIDDEN = 0.1
FINEST = 12  # largest number of slices per factor of a plane


@dataclass(frozen=True)
class FailureComparison:
    """Comparison of failing with passing trials, factor by factor.

    `name`: requirement that decides between failing and passing, or "" for all requirements
        together. "not simulated": the failing trials are those that could not be simulated, the
        passing trials are all others.
    `failing`, `passing`: numbers of trials.
    `regions` (d,): comparison for each factor; the p-values are corrected for all comparisons.
    """

    name: str
    failing: int
    passing: int
    regions: tuple[FailureRegion, ...]

    @property
    def order(self) -> tuple[int, ...]:
        """Return the indices of the factors, in the order of their p-values."""
        return tuple(
            sorted(
                range(len(self.regions)),
                key=lambda i: (self.regions[i].chance or 0.0, -self.regions[i].distance),
            )
        )

    @property
    def named(self) -> tuple[int, ...]:
        """Return the indices of the factors with a significant influence; lowest p-value first."""
        return tuple(
            i
            for i in self.order
            if _believed(self.regions[i].chance, self.regions[i].distance > LEAST_DISTANCE)
        )


@dataclass(frozen=True)
class MetricInfluence:
    """Influence of the factors on one metric.

    `used`: number of trials with a finite value.
    `shares` (d,): variance share of each factor; empty if the shares cannot be estimated.
    `reason`: why `shares` is empty; "" if `shares` is not empty.
    """

    used: int
    shares: tuple[VarianceShare, ...] = ()
    reason: str = ""

    @property
    def rest(self) -> float | None:
        """Return the share of the metric's variance that no factor in `named` explains alone.

        This share is due to interactions, noise, and effects within a slice of a factor's range.
        """
        return (
            max(0.0, 1.0 - sum(max(0.0, self.shares[i].share) for i in self.named))
            if self.shares
            else None
        )

    @property
    def rest_of_ranks(self) -> float | None:
        """Return the share of the rank variance that no factor in `named` explains alone."""
        return (
            max(0.0, 1.0 - sum(max(0.0, self.shares[i].of_ranks) for i in self.named))
            if self.shares
            else None
        )

    @property
    def by_rank(self) -> bool:
        """Return True if a factor explains clearly more variance of the ranks than of the values.

        The ranks are then more informative: a few very large values dominate the variance of the
        values.
        """
        return any(self.shares[i].of_ranks - self.shares[i].share > HIDDEN for i in self.named)

    @property
    def order(self) -> tuple[int, ...]:
        """Return the indices of the factors, the largest share first."""
        return tuple(sorted(range(len(self.shares)), key=lambda i: -self.shares[i].share))

    @property
    def named(self) -> tuple[int, ...]:
        """Return the indices of the factors with a significant influence, largest share first."""
        return tuple(
            i
            for i in self.order
            if _believed(self.shares[i].chance, self.shares[i].share > LEAST_SHARE)
        )


@dataclass(frozen=True)
class FactorPair:
    """The two factors that together explain the failures best.

    `first`, `second`: indices of the factors.
    `joint`: share of the variance of the outcome (0 pass, 1 fail) that the two factors explain,
        alone or together.
    `beyond`: share of this variance that they explain only together.
    `error`: standard deviation of `beyond` for factors without an interaction.
    """

    first: int
    second: int
    joint: float
    beyond: float
    error: float


@dataclass(frozen=True)
class Sensitivity:
    """Sensitivity of failures and metrics.

    `questions`: comparisons of failing with passing trials: for all requirements together, for
        each requirement, and for trials that could not be simulated (see `masks`).
    `influences` (m,): influence of the factors on each metric.
    `pair`: pair of factors that explains the failures best; None if no trial fails, if no trial
        passes, or if there is only one factor.
    """

    questions: tuple[FailureComparison, ...]
    influences: tuple[MetricInfluence, ...]
    pair: FactorPair | None


def sensitivity(trials: Trials, drawn: bool) -> Sensitivity:
    """Return the sensitivities of the trials; `drawn` is False if all vertices were simulated."""
    draws = SortedDraws(trials)
    questions, influences = _questions(trials, draws, drawn), _influences(trials, draws, drawn)
    return Sensitivity(
        questions,
        influences,
        _pair(trials, draws, drawn) if questions and questions[0].name == "" else None,
    )


def masks(trials: Trials) -> list[tuple[str, BoolVector, BoolVector]]:
    """Return (name, mask of failing trials, mask of passing trials) for each comparison.

    The first comparison is for all requirements together and has the name "". The comparisons for
    single requirements follow, and "not simulated" for the trials that could not be simulated. A
    comparison is left out if no trial fails, if no trial passes, or if an earlier comparison has
    the same masks.
    """
    questions = [("", trials.passed == BROKEN, trials.passed == MET)]
    questions += [
        (metric.name, trials.met[:, j] == BROKEN, trials.met[:, j] == MET)
        for j, metric in enumerate(trials.metrics)
    ]
    not_run = np.isin(np.arange(trials.count), list(trials.failed))
    questions.append(("not simulated", not_run, ~not_run))
    kept: list[tuple[str, BoolVector, BoolVector]] = []
    for name, failing, passing in questions:
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
    questions = masks(trials)
    regions: list[FailureRegion] = []
    for _, failing, passing in questions:
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
        for k, (name, failing, passing) in enumerate(questions)
    )


def _influences(trials: Trials, draws: SortedDraws, drawn: bool) -> tuple[MetricInfluence, ...]:
    influences = [_influence(trials, draws, j, drawn) for j in range(len(trials.metrics))]
    shares = [share for influence in influences for share in influence.shares]
    if not drawn or not shares:
        return tuple(influences)
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
        for one in influences
    )


def _adding_up(one: MetricInfluence) -> MetricInfluence:
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
    values = trials.metric_values[:, metric]
    known = ~np.isnan(values)
    finite = np.isfinite(values)
    count, used = int(known.sum()), int(finite.sum())
    if count == 0:
        return MetricInfluence(used, reason="no trial has a value")
    if count < FEWEST and drawn:
        return MetricInfluence(used, reason=f"{count} trials have a value, {FEWEST} are needed")
    scores = scores_of(values[known])
    if not scores:
        return MetricInfluence(used, reason="the value is the same in every trial")
    shares = []
    for factor in range(trials.space.size):
        ranked = draws.sliced(factor, slices_for(count), known)
        slices = ranked if used == count else draws.sliced(factor, slices_for(used), finite)
        few = draws.sliced(factor, few_slices_for(count), known)
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
