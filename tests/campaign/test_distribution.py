"""Quantiles and tolerance bounds: held to what the beta distribution of order statistics says;
histograms that lose no trial."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from frictool.campaign.statistics.distribution import (
    COVERED,
    _reach,
    distribution,
    fewest,
    rank,
)
from frictool.campaign.trials.trials import BROKEN, UNDECIDED, MetricLimit, Trials
from tests.support.campaign_trials import factors, trials_of


def _with(trials: Trials, values: np.ndarray, relation: str = "<=", limit: float = 0.5) -> Trials:
    """The same trials with another metric."""
    kept = np.where(
        np.isnan(values), UNDECIDED, (values <= limit) if relation == "<=" else (values >= limit)
    ).astype(np.int8)
    metric = MetricLimit("metric", "metric", "1", limit, relation)
    return dataclasses.replace(
        trials, metrics=(metric,), metric_values=values[:, None], met=kept[:, None], passed=kept
    )


def trials(values: np.ndarray, relation: str = "<=", limit: float = 0.5) -> Trials:
    return _with(
        trials_of(factors(1), [lambda v: v[:, 0]], [limit], values.size), values, relation, limit
    )


def test_59_draws_are_the_fewest_for_95_percent_with_95_percent() -> None:
    assert fewest("random") == 59
    assert fewest("latin") == 60
    assert distribution(trials(np.arange(58.0)), 0, "random").bound is None
    assert distribution(trials(np.arange(59.0)), 0, "random").bound == 58.0


@pytest.mark.parametrize("draws", [59, 93, 200, 1000])
def test_the_bound_is_the_least_order_statistic_that_covers_as_often_as_it_says(draws: int) -> None:
    place = rank(draws, COVERED, 0.95, "random")
    assert place is not None
    # of n uniform draws the share below the r-th is Beta(r, n - r + 1)
    assert stats.beta.sf(COVERED, place, draws - place + 1) >= 0.95
    assert place == 1 or stats.beta.sf(COVERED, place - 1, draws - place + 2) < 0.95


@pytest.mark.parametrize("level", [0.05, 0.5, 0.95])
def test_the_interval_of_a_quantile_misses_it_as_rarely_as_it_says(level: float) -> None:
    n = 400
    found = distribution(trials(np.arange(1.0, n + 1.0)), 0, "random").quantiles
    one = next(q for q in found if q.level == level)
    assert one.value == level * n
    assert one.low is not None
    assert one.high is not None
    # of n uniform draws the r-th smallest is Beta(r, n - r + 1): how often the upper end lies below
    # the quantile, the lower one above it
    assert stats.beta.cdf(level, one.high, n - one.high + 1) <= 0.025
    assert stats.beta.sf(level, one.low, n - one.low + 1) <= 0.025
    assert stats.beta.cdf(level, one.high - 1, n - one.high + 2) > 0.025  # no nearer value does
    assert stats.beta.sf(level, one.low + 1, n - one.low) > 0.025


def test_too_few_draws_leave_the_interval_of_an_outer_quantile_open() -> None:
    fifth, half, last = distribution(trials(np.arange(1.0, 31.0)), 0, "random").quantiles
    assert (fifth.level, fifth.low) == (0.05, -np.inf)
    assert (last.level, last.high) == (0.95, np.inf)
    for quantile, ends in (
        (fifth, [fifth.high]),
        (half, [half.low, half.high]),
        (last, [last.low]),
    ):
        assert all(end is not None and np.isfinite(end) for end in ends), quantile


def test_trials_without_a_value_are_taken_as_the_worst_by_the_bound_and_not_by_the_quantiles() -> (
    None
):
    values = np.arange(200.0)
    whole = distribution(trials(values), 0, "random")
    values[[3, 50]] = np.nan
    some = distribution(trials(values), 0, "random")
    assert some.missing == 2
    assert some.undecided == 2
    assert some.bound is not None
    assert whole.bound is not None
    assert some.bound > whole.bound
    values[:20] = np.nan
    assert distribution(trials(values), 0, "random").bound is None


def test_of_a_metric_that_shall_be_large_the_bound_is_below() -> None:
    values = np.random.default_rng(1).normal(size=500)
    low = distribution(trials(values, ">=", 0.5), 0, "random")
    high = distribution(trials(-values, "<=", 0.5), 0, "random")
    assert low.bound == -high.bound
    assert low.worst == values.min()
    assert low.worst_trial == values.argmin()


def test_what_never_comes_to_a_value_is_the_worst_and_in_no_bin() -> None:
    values = np.linspace(0.0, 1.0, 100)
    values[7] = np.inf
    found = distribution(trials(values), 0, "random")
    assert found.beyond == 1
    assert found.worst == np.inf
    assert found.worst_trial == 7
    assert found.histogram.counts.sum() == 99
    assert found.broken == np.count_nonzero(values > 0.5)


def test_without_any_value_there_is_nothing() -> None:
    found = distribution(trials(np.full(80, np.nan)), 0, "random")
    assert not found.has_values
    assert found.quantiles == ()
    assert found.bound is found.worst is found.worst_trial is None


def test_all_vertices_have_no_intervals() -> None:
    found = distribution(trials(np.arange(64.0)), 0, "vertices")
    assert found.bound is None
    assert all(q.low is q.high is None for q in found.quantiles)


@given(
    arrays(float, st.integers(1, 60), elements=st.floats(-1e6, 1e6, width=32)),
    st.data(),
    st.sampled_from(["<=", ">="]),
)
def test_a_histogram_loses_no_trial_and_no_bin_has_both_sides_of_the_limit(
    values: np.ndarray, data: st.DataObject, relation: str
) -> None:
    limit = data.draw(st.one_of(st.sampled_from(values.tolist()), st.floats(-1e6, 1e6, width=32)))
    bins = distribution(trials(values, relation, limit), 0, "random").histogram
    assert bins.counts.sum() == values.size
    assert np.all(np.diff(bins.edges) > 0.0)
    if bins.counts.size > 1 and values.min() <= limit <= values.max():
        assert limit in bins.edges
        at_most = np.count_nonzero(values <= limit if relation == "<=" else values < limit)
        assert bins.counts[bins.edges[1:] <= limit].sum() == at_most


def test_a_few_that_are_far_from_the_others_do_not_make_these_one_bar() -> None:
    values = np.concatenate([np.linspace(1.0, 2.0, 990), np.full(10, 1e4)])
    bins = distribution(trials(values, limit=1.5), 0, "random").histogram
    assert bins.outside == 10
    assert bins.counts.sum() == 990
    assert np.count_nonzero(bins.counts) > 15
    assert 1.5 in bins.edges
    assert (
        distribution(trials(values, limit=5000.0), 0, "random").histogram.edges[-1] > 5000.0
    )  # the limit has values beyond it


def test_a_broken_requirement_is_counted() -> None:
    made = trials(np.array([0.1, 0.6, 0.7, np.nan]))
    found = distribution(made, 0, "random")
    assert (found.met, found.broken, found.undecided) == (1, 2, 1)
    assert np.count_nonzero(made.met == BROKEN) == 2


def test_one_draw_bounds_the_share_that_a_single_value_bounds() -> None:
    """P(F(x) >= p) = 1 - p for a uniform F(x): at a confidence of 60 % one value bounds 40 %."""
    assert rank(1, 0.39, 0.6, "random") == 1
    assert rank(1, 0.41, 0.6, "random") is None
    assert rank(0, 0.39, 0.6, "random") is None


@pytest.mark.parametrize("limit", [-50.0, 50.0])
def test_a_histogram_reaches_beyond_a_limit_among_far_values(limit: float) -> None:
    """It reaches beyond the limit by the width of the middle 90 %, and leaves out the outliers."""
    values = np.concatenate((np.linspace(0.0, 1.0, 400), [-100.0, 100.0]))
    low, high = _reach(values, limit)
    body = float(np.diff(np.quantile(values, (0.05, 0.95)))[0])
    if limit < 0.0:
        assert low == pytest.approx(limit - body)
        assert 1.0 < high < 50.0
    else:
        assert high == pytest.approx(limit + body)
        assert -50.0 < low < 0.0
