"""The search for the worst case, on functions whose worst point is known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from frictool.campaign.trials.differential_evolution import search_worst
from frictool.typing import Vector

PEAK = np.array([0.31, 0.87, 0.52])


def valley(u: Vector) -> float:
    """At the corner (1, 0, 1, 0, ..): linear."""
    return float(np.sum(u * np.where(np.arange(u.size) % 2 == 0, 1.0, -1.0)))


def inside(u: Vector) -> float:
    """Between the ends, at PEAK."""
    return -float(np.sum((u - PEAK) ** 2))


def mixed(u: Vector) -> float:
    """At an end of two factors, between those of the third; jumps at every hundredth of a
    factor."""
    return float(u[0] + np.floor(100.0 * u[1]) / 100.0 - 4.0 * (u[2] - 0.4) ** 2)


def product(u: Vector) -> float:
    """Two factors have to move together: worst (1, 1), each alone better than (0, 0) from where it
    begins."""
    return float(3.0 * u[0] * u[1] - u[0] - u[1])


@pytest.mark.parametrize(
    ("badness", "factors", "worst", "error"),
    [(valley, 8, 4.0, 0.0), (inside, 3, 0.0, 1e-4), (mixed, 3, 2.0, 1e-4), (product, 2, 1.0, 0.0)],
)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_known_worst_point_is_found_and_is_worse_than_any_draw(
    badness: Callable[[Vector], float], factors: int, worst: float, error: float, seed: int
) -> None:
    draws = np.random.default_rng(seed).random((200, factors))
    drawn = sorted(draws, key=badness)
    found = search_worst(badness, np.stack(drawn[-4:]), 400, seed)
    assert found.worst == pytest.approx(worst, abs=error)
    assert found.worst == badness(found.at)
    assert found.worst > max(badness(u) for u in draws)
    assert found.tried <= 400


def test_it_counts_stays_in_the_box_and_is_the_same_for_a_seed() -> None:
    tried = list[Vector]()

    def watched(u: Vector) -> float:
        tried.append(u.copy())
        return inside(u)

    first, again = (
        search_worst(watched, np.full((1, 3), 0.5), 150, 7),
        search_worst(inside, np.full((1, 3), 0.5), 150, 7),
    )
    assert len(tried) == first.tried == 150
    assert 0.0 <= np.min(tried) <= np.max(tried) <= 1.0
    np.testing.assert_array_equal(first.at, again.at)
    assert search_worst(inside, np.full((1, 3), 0.5), 150, 8).at.tolist() != first.at.tolist()


def test_few_evaluations_are_not_exceeded_and_never_give_less_than_the_start() -> None:
    for evaluations in (1, 2, 3, 5, 10):
        found = search_worst(inside, PEAK[None], evaluations, 0)
        assert found.tried <= evaluations
        np.testing.assert_array_equal(found.at, PEAK)


def test_it_ends_where_nothing_can_be_worse_and_passes_over_what_has_no_value() -> None:
    assert (
        search_worst(lambda u: math.inf if u[0] == 1.0 else 0.0, np.full((1, 2), 0.5), 500, 0).tried
        < 10
    )
    hole = search_worst(
        lambda u: -math.inf if u[0] < 0.9 else float(u[1]), np.array([[0.95, 0.1]]), 200, 0
    )
    assert hole.worst == 1.0
