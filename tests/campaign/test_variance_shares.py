"""Shares of variance of functions whose indices are known; errors that are as large as they say; a
dummy that is not called important."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.statistics.sensitivity import MetricInfluence, sensitivity
from frictool.campaign.statistics.slices import SortedDraws, few_slices_for
from frictool.campaign.statistics.sobol_indices import chance_of_ranks, scores_of
from tests.support.campaign_trials import Function, factors, trials_of
from tests.support.sensitivity_functions import (
    FUNCTIONS,
    Array,
    vertices,
)

SEEDS = range(30)


def influence(space: FactorSpace, function: Function, n: int, seed: int = 0) -> MetricInfluence:
    return sensitivity(trials_of(space, [function], [np.inf], n, seed), drawn=True).influences[0]


def shares(space: FactorSpace, function: Function, n: int) -> tuple[Array, Array]:
    """Estimates and their errors, a row a seed."""
    found = [influence(space, function, n, seed).shares for seed in SEEDS]
    return np.array([[s.share for s in row] for row in found]), np.array(
        [[s.error for s in row] for row in found]
    )


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_shares_are_those_that_are_known_and_their_errors_those_that_they_have(
    name: str,
) -> None:
    space, function, known = FUNCTIONS[name]
    found, errors = shares(space, function, 1000)
    assert (
        np.abs(found.mean(axis=0) - known).max() < 0.015
    )  # of which slices that are not infinitely fine take a part
    spread, told = found.std(axis=0), errors.mean(axis=0)
    assert np.all(spread < 1.45 * told)  # 30 seeds know a deviation to 13 %
    assert np.all(spread[known > 0.1] > 0.6 * told[known > 0.1])


def test_more_trials_come_nearer() -> None:
    space, function, known = FUNCTIONS["ishigami"]
    found = influence(space, function, 20_000)
    assert np.abs([s.share for s in found.shares] - known).max() < 0.01
    assert found.rest == pytest.approx(0.243684, abs=0.02)  # what x1 and x3 do together
    assert found.named[:2] == (1, 0)
    assert set(found.named) == {0, 1, 2}  # x3 acts, though it has no share of its own


def test_directions_are_those_of_the_function() -> None:
    space, function, _ = FUNCTIONS["linear"]
    told = influence(space, function, 1000).shares
    assert [s.direction for s in told[:3]] == ["rises", "falls", "rises"]
    assert (
        influence(factors(2), lambda v: (v[:, 0] - 0.5) ** 2, 1000).shares[0].direction
        == "up and down"
    )


def _no_influence(v: Array) -> Array:
    """Heavy tails, ties and values beyond any, none of it from the last four factors."""
    wild = np.exp(8.0 * v[:, 0]) * (v[:, 1] > 0.3)
    return np.where(v[:, 0] * v[:, 1] > 0.7, np.inf, wild)


@pytest.mark.parametrize("campaigns", [40, pytest.param(100, marks=pytest.mark.accept)])
def test_in_a_table_a_dummy_is_called_important_as_rarely_as_it_says(campaigns: int) -> None:
    space, wrong = factors(6), 0
    for seed in range(campaigns):
        found = sensitivity(
            trials_of(space, [_no_influence, linear_of_first], [1.0, 0.2], 120, seed), drawn=True
        )
        wrong += any(
            factor >= 2 for one in (*found.influences, *found.questions) for factor in one.named
        )
    # two tables of each campaign, each wrong with 5 % at most; uncorrected it would be 8 times that
    assert wrong <= stats.binom.ppf(0.999, campaigns, 0.1)


def linear_of_first(v: Array) -> Array:
    return np.asarray(v[:, 0])


def test_the_probability_of_a_factor_without_influence_is_uniform() -> None:
    rng, found = np.random.default_rng(5), []
    trials = trials_of(factors(1), [linear_of_first], [1.0], 300)
    slices = SortedDraws(trials).sliced(0, few_slices_for(300), np.ones(300, dtype=bool))
    for make in (
        rng.normal,
        rng.standard_cauchy,
        lambda size: np.maximum(0.0, rng.normal(size=size)),
    ):  # the last with ties
        chances = np.array([chance_of_ranks(slices, scores_of(make(size=300))) for _ in range(250)])
        found.append(stats.kstest(chances, "uniform").pvalue)
    assert min(found) > 0.001


def test_one_enormous_value_upsets_nothing() -> None:
    def with_one(v: Array) -> Array:
        return np.where(np.arange(v.shape[0]) == 7, 1e12, v[:, 0] + 0.01 * v[:, 1])

    assert influence(factors(3), with_one, 400).named[0] in (0, 1)
    assert 2 not in influence(factors(3), with_one, 400).named


@pytest.mark.parametrize(
    ("function", "n", "reason"),
    [
        (lambda v: np.zeros(v.shape[0]), 200, "the value is the same in every trial"),
        (lambda v: np.full(v.shape[0], np.nan), 200, "no trial has a value"),
        (linear_of_first, 12, "12 trials have a value, 20 are needed"),
    ],
)
def test_where_nothing_can_be_told_it_is_said(
    function: Callable[[Array], Array], n: int, reason: str
) -> None:
    assert influence(factors(2), function, n).reason == reason


def test_the_shares_of_all_vertices_are_exact() -> None:
    found = sensitivity(
        vertices(4, lambda v: 3.0 * _sign(v, 0) + 2.0 * _sign(v, 1) + _sign(v, 0) * _sign(v, 2)),
        drawn=False,
    ).influences[0]
    np.testing.assert_allclose(
        [s.share for s in found.shares], [9.0 / 14.0, 4.0 / 14.0, 0.0, 0.0], atol=1e-12
    )
    assert found.rest == pytest.approx(1.0 / 14.0)
    assert all(s.chance is None and s.error == 0.0 for s in found.shares)
    assert found.named == (0, 1)


def test_at_vertices_a_breakaway_has_no_share_of_its_coulomb_friction() -> None:
    """Its low end is where that friction is; what it does by itself is from its low end to its high
    one."""
    trials = vertices(2, linear_of_first)
    first, second = trials.space.factors
    space = FactorSpace((first, replace(second, least=("x1", 0.5))))
    found = sensitivity(
        replace(trials, space=space, values=space.values(trials.units)), drawn=False
    ).influences[0]
    assert [s.share for s in found.shares] == pytest.approx([1.0, 0.0])


def test_two_vertices_of_one_factor_tell_all_of_it() -> None:
    assert sensitivity(vertices(1, linear_of_first), drawn=False).influences[0].shares[
        0
    ].share == pytest.approx(1.0)


@pytest.mark.parametrize("unit", [1e300, 1e-300, -1.0])
def test_a_share_has_no_unit(unit: float) -> None:
    space, function, _ = FUNCTIONS["linear"]
    scaled = influence(space, lambda v: unit * 0.1 * function(v), 200)
    assert [s.share for s in scaled.shares] == pytest.approx(
        [s.share for s in influence(space, function, 200).shares], rel=1e-9
    )


def _sign(v: Array, factor: int) -> Array:
    return np.asarray(2.0 * v[:, factor] - 1.0)


def test_the_scores_of_ranks_with_ties_are_orthogonal_and_have_no_mean() -> None:
    values = np.concatenate((np.zeros(30), np.arange(10.0), [np.inf] * 5))
    location, spread = scores_of(values)
    assert location.mean() == pytest.approx(0.0, abs=1e-12)
    assert spread.mean() == pytest.approx(0.0, abs=1e-12)
    assert location @ spread == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.diff(location[30:40]) > 0.0)
    assert np.unique(location[:30]).size == np.unique(location[40:]).size == 1
