"""Where failures lie: distances, probabilities and directions of one factor, and Holm's
correction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from frictool.campaign.statistics.holm_correction import holm_corrected
from frictool.campaign.statistics.regional_sensitivity import FailureRegion, region
from frictool.campaign.statistics.slices import Slices

Array = np.ndarray


def tell(units: Array, failing: Array, drawn: bool = True) -> FailureRegion:
    """In ten slices, at values twice the place."""
    return region(
        units,
        2.0 * units,
        failing,
        Slices(np.minimum(9, (10.0 * units).astype(np.int64)), 10),
        drawn,
    )


@settings(max_examples=30)
@given(st.integers(0, 2**32), st.integers(1, 30), st.integers(1, 30))
def test_the_distance_and_the_leaning_are_those_of_the_definition(
    seed: int, bad: int, good: int
) -> None:
    rng = np.random.default_rng(seed)
    units = np.concatenate(
        [np.linspace(0.0, 1.0, 10), np.round(rng.random(bad + good), 2)]
    )  # a draw in every slice; with ties
    failing = np.arange(units.size) < bad + 5
    found = tell(units, failing)
    below = np.array([[np.mean(units[mask] <= x) for x in units] for mask in (failing, ~failing)])
    assert found.distance == pytest.approx(np.abs(below[0] - below[1]).max())
    apart = np.sign(units[failing][:, None] - units[~failing][None, :])
    assert found.leans == pytest.approx(apart.mean())


@pytest.mark.parametrize(
    ("fails", "direction"),
    [
        (lambda u: u > 0.8, "high"),
        (lambda u: u < 0.3, "low"),
        (lambda u: np.abs(u - 0.5) > 0.4, "both ends"),
        (lambda u: np.abs(u - 0.5) < 0.1, "the middle"),
    ],
)
def test_the_direction_is_where_the_failures_are(fails, direction: str) -> None:
    units = np.random.default_rng(2).random(300)
    found = tell(units, fails(units))
    assert found.direction == direction
    assert found.chance is not None
    assert found.chance < 1e-6
    np.testing.assert_allclose(
        found.centres, [2.0 * units[(10.0 * units).astype(int) == k].mean() for k in range(10)]
    )
    assert found.failing.max() == 1.0


def test_few_failures_of_many_trials_are_told_and_many_as_fast() -> None:
    rng = np.random.default_rng(3)
    units = rng.random(100_000)
    few = tell(
        units, units > 1.0 - 5e-5
    )  # some failures, all at the end: each is as unlikely as that
    assert few.chance is not None
    assert few.chance < 1e-6
    none = tell(units, rng.random(100_000) < 0.3)
    assert none.chance is not None
    assert none.chance > 1e-4


def test_the_probability_of_a_factor_without_influence_is_uniform() -> None:
    rng = np.random.default_rng(4)
    for bad, good in (
        (40, 400),
        (1500, 3000),
    ):  # counted; from one sample of as many as they are worth
        chances = [
            tell(units, np.arange(bad + good) < bad).chance
            for units in rng.random((100, bad + good))
        ]
        assert stats.kstest([c for c in chances if c is not None], "uniform").pvalue > 1e-3


def test_without_both_kinds_there_is_nothing_to_compare() -> None:
    for failing in (np.ones(10, dtype=bool), np.zeros(10, dtype=bool)):
        with pytest.raises(ValueError, match="failing and passing trials"):
            tell(np.linspace(0.0, 1.0, 10), failing)


def test_holm_corrects_in_order() -> None:
    np.testing.assert_allclose(
        holm_corrected(np.array([0.01, 0.04, 0.03, 0.005])), [0.03, 0.06, 0.06, 0.02]
    )
    np.testing.assert_allclose(holm_corrected(np.array([0.9, 0.5])), [1.0, 1.0])


@settings(max_examples=30)
@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_holm_lowers_no_probability_and_never_more_than_bonferroni(chances: list[float]) -> None:
    before = np.array(chances)
    after = holm_corrected(before)
    assert np.all(after >= before)
    assert np.all(after <= np.minimum(1.0, before.size * before) + 1e-15)
    assert np.all(np.diff(after[np.argsort(before, kind="stable")]) >= 0.0)
