"""Bounds of a share: the exact ones of Clopper and Pearson, and how often they hold, summed and not
sampled."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.clopper_pearson import draws_to_show, interval, lower, upper

COUNTS = st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(COUNTS, st.floats(0.5, 0.999))
def test_the_interval_is_that_of_clopper_and_pearson(
    counts: tuple[int, int], confidence: float
) -> None:
    count, draws = counts
    exact = stats.binomtest(count, draws).proportion_ci(confidence, "exact")
    assert interval(count, draws, confidence) == pytest.approx((exact.low, exact.high), abs=1e-9)


def test_where_none_fails_the_bound_is_the_rule_of_three() -> None:
    for n in (10, 1000, 100_000):
        assert 1.0 - lower(n, n) == pytest.approx(1.0 - 0.05 ** (1.0 / n), rel=1e-9)
    assert 1.0 - lower(1000, 1000) == pytest.approx(3.0 / 1000, rel=0.01)
    assert lower(0, 5) == 0.0
    assert upper(5, 5) == 1.0


@pytest.mark.parametrize("draws", [1, 7, 40, 150])
def test_the_bounds_hold_at_least_as_often_as_they_say(draws: int) -> None:
    counts = np.arange(draws + 1)
    ends = np.array([interval(int(k), draws) for k in counts])
    below = np.array([lower(int(k), draws) for k in counts])
    for share in np.linspace(0.001, 0.999, 333):
        chances = stats.binom.pmf(counts, draws, share)
        assert chances[(ends[:, 0] > share) | (ends[:, 1] < share)].sum() <= 0.05 + 1e-12
        assert chances[below > share].sum() <= 0.05 + 1e-12


def _missed(draws: int, method: Method) -> float:
    """Return how often the interval misses 1/2 in a Latin hypercube, if a plant fails when just one
    of two factors is in its upper half.

    n/2 draws have x1 < 1/2, and H of them, hypergeometric, x2 < 1/2 too: n - 2 H fail. Nothing of
    it is what either factor does alone.
    """
    both = np.arange(draws // 2 + 1)
    chances = stats.hypergeom.pmf(both, draws, draws // 2, draws // 2)
    ends = np.array([interval(int(draws - 2 * k), draws, 0.95, method) for k in both])
    return float(chances[(ends[:, 0] > 0.5) | (ends[:, 1] < 0.5)].sum())


def test_the_interval_of_a_latin_hypercube_holds_where_factors_act_only_together() -> None:
    sizes = [*range(4, 120, 2), 206, 336, 764]
    assert (
        sum(_missed(draws, "random") > 0.05 for draws in sizes) > 10
    )  # as if the draws were independent
    assert all(_missed(draws, "latin") <= 0.05 for draws in sizes)


@pytest.mark.parametrize("draws", [10, 60, 400])
def test_a_failure_that_no_draw_of_a_latin_hypercube_meets_is_as_rare_as_the_bound_says(
    draws: int,
) -> None:
    """A band of width 1/n about the diagonal of two factors: its draws are the fixed points of a
    permutation, of which 1 in e has none."""
    assert lower(draws, draws, 1.0 - np.exp(-1.0), "latin") <= 1.0 - 1.0 / draws
    assert (
        lower(draws, draws, 1.0 - np.exp(-1.0), "random") > 1.0 - 1.0 / draws
    )  # n independent draws would have been believed


def test_how_many_draws_would_show_a_rate_is_the_least_number_that_does() -> None:
    assert draws_to_show(0.99, 1.0) == math.ceil(math.log(0.05) / math.log(0.99)) == 299
    assert draws_to_show(0.99, 1.0, method="latin") == 300
    needed = draws_to_show(0.95, 0.97)
    assert needed is not None
    assert lower(int(0.97 * needed + 1e-9), needed) >= 0.95
    assert draws_to_show(0.95, 0.95) is None
    assert draws_to_show(1.0, 1.0) is None


def test_up_to_2_to_the_40_draws_are_told() -> None:
    """About 0.676 / d^2 draws show a rate of 1/2 where 1/2 + d of them pass."""
    found = draws_to_show(0.5, 0.5 + 9.05e-7)
    assert found is not None
    assert 1 << 39 < found <= 1 << 40
    assert found == pytest.approx(stats.norm.ppf(0.95) ** 2 / 4.0 / 9.05e-7**2, rel=1e-3)
    assert draws_to_show(0.5, 0.5 + 5e-7) is None
