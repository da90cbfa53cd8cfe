"""Weighted least squares and its jackknife: against the definition, one cluster left out at a
time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.regression.multiway import equal_bins, shared_variance
from frictool.identify.regression.regression import SingularRegressors, solve


@settings(derandomize=True, deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), count=st.integers(3, 12))
def test_solution_and_spread_follow_the_definition(seed: int, count: int) -> None:
    generator = np.random.default_rng(seed)
    cluster = np.sort(
        np.concatenate((np.repeat(np.arange(count), 6), generator.integers(0, count, 20)))
    )
    rows = generator.normal(size=(cluster.size, 3)) * [1e-3, 1.0, 50.0]
    weight = generator.uniform(0.1, 2.0, cluster.size)
    target = rows @ [4.0, -1.0, 0.2] + generator.normal(size=cluster.size)
    found = solve(rows, target, weight, cluster)

    def plain(kept: np.ndarray) -> np.ndarray:
        return np.linalg.lstsq(
            rows[kept] * weight[kept, None], target[kept] * weight[kept], rcond=None
        )[0]

    assert found.value == pytest.approx(plain(cluster >= 0), rel=1e-8)
    left_out = np.array([plain(cluster != g) for g in range(count)])
    spread = np.sqrt((count - 1) / count * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    assert found.deviation == pytest.approx(spread, rel=1e-6)
    scaled = rows * weight[:, None]
    assert found.condition == pytest.approx(
        np.linalg.cond(scaled / np.linalg.norm(scaled, axis=0)), rel=1e-8
    )
    assert np.all(found.freedom <= count - 1 + 1e-9)


def test_equal_clusters_have_one_degree_less_than_their_number() -> None:
    generator = np.random.default_rng(1)
    block = generator.normal(size=(10, 2))
    found = solve(
        np.tile(block, (9, 1)), generator.normal(size=90), np.ones(90), np.repeat(np.arange(9), 10)
    )
    assert found.freedom == pytest.approx([8.0, 8.0])
    assert found.half_width(0.95) == pytest.approx(found.deviation * 2.306004, rel=1e-5)


def test_intervals_cover_under_correlated_residuals() -> None:
    """A random level per cluster: the textbook interval would cover a third of the time."""
    generator = np.random.default_rng(7)
    cluster, hits = np.repeat(np.arange(20), 50), 0
    for _ in range(300):
        level = np.repeat(generator.normal(size=20), 50) + 0.1 * generator.normal(size=1000)
        found = solve(np.ones((1000, 1)), 3.0 + level, np.ones(1000), cluster)
        hits += abs(found.value[0] - 3.0) <= found.half_width(0.95)[0]
    assert 270 <= hits <= 297  # 95 % of 300 is 285; four standard deviations


def test_dependent_regressors_are_refused() -> None:
    rows = np.column_stack((np.arange(20.0), 2.0 * np.arange(20.0)))
    with pytest.raises(SingularRegressors):
        solve(rows, np.ones(20), np.ones(20), np.repeat(np.arange(4), 5))


def test_one_cluster_tells_no_spread() -> None:
    found = solve(
        np.arange(1.0, 21.0)[:, None], np.ones(20), np.ones(20), np.zeros(20, dtype=np.int64)
    )
    assert np.isinf(found.deviation).all()


def test_clusters_need_not_lie_together() -> None:
    generator = np.random.default_rng(5)
    rows, target, cluster = (
        generator.normal(size=(60, 2)),
        generator.normal(size=60),
        np.repeat(np.arange(6), 10),
    )
    mixed = generator.permutation(60)
    found, again = (
        solve(rows, target, np.ones(60), cluster),
        solve(rows[mixed], target[mixed], np.ones(60), cluster[mixed]),
    )
    assert again.deviation == pytest.approx(found.deviation)
    assert again.freedom == pytest.approx(found.freedom)


def shared(seed: int, repeated: float) -> tuple[float, float]:
    """Return the estimate of a slope 0, and the variance that bins of the position add to it.

    In each of 30 strokes, every bin of the position has the same effort, and each row has noise.
    """
    draw = np.random.default_rng(seed)
    stroke = np.repeat(np.arange(30), 60)
    position = np.tile(np.linspace(0.0, 1.0, 60), 30)
    bins = equal_bins(position, 20)
    columns = np.column_stack((position, np.ones(position.size)))
    target = repeated * draw.normal(size=20)[bins] + draw.normal(size=position.size)
    value = np.linalg.lstsq(columns, target, rcond=None)[0]
    variance = shared_variance(columns, target - columns @ value, stroke, [bins])
    return float(value[0]), float(variance[0])


def test_effects_that_all_strokes_share_are_seen_between_bins() -> None:
    drawn = np.array([shared(seed, 0.5) for seed in range(400)])
    assert np.mean(drawn[:, 1]) == pytest.approx(np.var(drawn[:, 0]), rel=0.25)


def test_independent_residuals_add_little() -> None:
    drawn = np.array([shared(seed, 0.0) for seed in range(400)])
    assert np.mean(drawn[:, 1]) < 0.1 * np.var(drawn[:, 0])


@given(seed=st.integers(0, 10_000), count=st.integers(2, 20))
def test_bins_hold_the_same_number_of_values(seed: int, count: int) -> None:
    values = np.random.default_rng(seed).normal(size=20 * count)
    assert np.bincount(equal_bins(values, count)).tolist() == [20] * count


def test_a_fit_without_free_parameters_is_refused() -> None:
    with pytest.raises(SingularRegressors, match="all parameters are fixed"):
        solve(np.empty((10, 0)), np.ones(10), np.ones(10), np.arange(10))
