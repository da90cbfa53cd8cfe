"""Shares of one whole: the nearest point to the estimates in units of their errors, and nearer to
every truth."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from frictool.campaign.statistics.sensitivity import sensitivity
from frictool.campaign.statistics.simplex_projection import within_whole
from tests.support.campaign_trials import factors, trials_of

SHARES = st.lists(
    st.tuples(st.floats(0.0, 1.2), st.floats(0.01, 0.3), st.floats(0.0, 1.0)),
    min_size=1,
    max_size=6,
)


@given(SHARES)
def test_what_is_found_can_be_and_is_nearer_to_whatever_is_true(
    drawn: list[tuple[float, float, float]],
) -> None:
    shares, errors, true = np.array(drawn).T
    true = true / max(1.0, true.sum())
    found = within_whole(shares, errors)
    assert np.all(found >= 0.0)
    assert found.sum() <= 1.0 + 1e-12
    assert np.sum(((found - true) / errors) ** 2) <= np.sum(((shares - true) / errors) ** 2) + 1e-9
    if shares.sum() <= 1.0:
        np.testing.assert_array_equal(found, shares)


def test_it_is_the_least_square_of_a_general_solver() -> None:
    rng = np.random.default_rng(3)
    for _ in range(5):
        shares, errors = rng.uniform(0.0, 0.8, 4), rng.uniform(0.02, 0.2, 4)
        limit = {"type": "ineq", "fun": lambda s: 1.0 - s.sum()}
        solved = minimize(
            lambda s, shares=shares, errors=errors: float(np.sum(((s - shares) / errors) ** 2)),
            np.full(4, 0.25),
            bounds=[(0.0, 1.0)] * 4,
            constraints=[limit],
            options={"ftol": 1e-14},
        )
        np.testing.assert_allclose(within_whole(shares, errors), solved.x, atol=1e-5)


def test_what_is_known_least_gives_most_and_what_is_below_0_stays() -> None:
    found = within_whole(np.array([0.8, 0.3, -0.02]), np.array([0.03, 0.09, 0.05]))
    np.testing.assert_allclose(found, [0.79, 0.21, -0.02])


def test_the_shares_that_a_campaign_tells_are_parts_of_one_whole() -> None:
    """Two factors that make all of the metric: without it a third of these campaigns would tell
    more than 100 %."""
    for seed in range(20):
        trials = trials_of(factors(3), [lambda v: 2.0 * v[:, 0] + v[:, 1]], [np.inf], 100, seed)
        one = sensitivity(trials, drawn=True).influences[0]
        told = [max(0.0, one.shares[i].share) for i in one.named]
        ranks = [max(0.0, one.shares[i].of_ranks) for i in one.named]
        assert sum(told) + (one.rest or 0.0) <= 1.0 + 1e-12
        assert sum(ranks) + (one.rest_of_ranks or 0.0) <= 1.0 + 1e-12
