"""Draws: of a seed the same, where they should be, and as many."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from frictool.campaign.draws.sampling import MOST_VERTICES, Method, draws_of, noise_seed


def test_a_random_draw_is_the_same_however_many_there_are() -> None:
    few, many = (draws_of("random", n, 5, seed=11).units for n in (7, 1000))
    np.testing.assert_array_equal(few, many[:7])
    assert np.all(few != draws_of("random", 7, 5, seed=12).units)


def test_random_draws_are_uniform_and_independent() -> None:
    units = draws_of("random", 4000, 4, seed=1).units
    assert min(stats.kstest(column, "uniform").pvalue for column in units.T) > 1e-3
    assert np.max(np.abs(np.corrcoef(units.T) - np.eye(4))) < 0.06  # standard deviation 0.016


@pytest.mark.parametrize("count", [1, 2, 37, 500])
def test_a_latin_hypercube_has_one_draw_in_each_part_of_each_factor(count: int) -> None:
    units = draws_of("latin", count, 6, seed=2).units
    for column in units.T:
        np.testing.assert_array_equal(np.sort(np.floor(column * count)), np.arange(count))


def test_a_latin_hypercube_has_means_that_vary_less() -> None:
    """The variance of the mean of a sum of functions of one factor each falls by more than a factor
    n (McKay, Beckman and Conover 1979)."""

    def means(method: Method) -> list[float]:
        draws = (draws_of(method, 50, 3, seed).units for seed in range(60))
        return [float(np.mean(np.sum(np.exp(units), axis=1))) for units in draws]

    assert np.std(means("latin")) < 0.1 * np.std(means("random"))


def test_all_vertices_are_there_once() -> None:
    draws = draws_of("vertices", None, 4, seed=0)
    assert draws.corners == 16
    assert draws.units[:3].tolist() == [[0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]]
    assert len({tuple(row) for row in draws.units}) == 16
    assert set(draws.units.ravel()) == {0.0, 1.0}


@pytest.mark.parametrize(
    ("factors", "asked", "count"),
    [(13, None, MOST_VERTICES), (70, None, MOST_VERTICES), (4, 5, 5), (4, 99, 16)],
)
def test_too_many_vertices_are_a_part_of_them(factors: int, asked: int | None, count: int) -> None:
    draws = draws_of("vertices", asked, factors, seed=3)
    assert draws.units.shape == (count, factors)
    assert draws.corners == 2**factors
    assert len({row.tobytes() for row in draws.units}) == count
    if count == MOST_VERTICES:  # each end of each factor as often: standard deviation 0.008
        assert np.max(np.abs(draws.units.mean(axis=0) - 0.5)) < 0.04
    np.testing.assert_array_equal(draws.units, draws_of("vertices", asked, factors, seed=3).units)


def test_noise_differs_from_draw_to_draw_and_is_of_the_seed() -> None:
    seeds = [noise_seed(1, draw) for draw in range(2000)]
    assert len(set(seeds)) == 2000
    assert all(0 <= seed < 2**63 for seed in seeds)
    assert noise_seed(1, 5) == seeds[5]
    assert noise_seed(2, 5) != seeds[5]
