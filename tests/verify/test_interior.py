"""Points inside the box, and the search for the worst plant."""

from __future__ import annotations

import numpy as np

from frictool.plant.parameter_box import DYNAMIC
from frictool.verify.interior_search import interior_points, searched, worst_norm
from tests.support.position_loop import BOX, CLUTCH, minimax_controller, plant


def test_points_fill_the_box_evenly_and_are_the_same_for_a_seed() -> None:
    points = interior_points(BOX, 256, 3)
    assert points == interior_points(BOX, 256, 3)
    assert points != interior_points(BOX, 256, 4)
    for name in (*DYNAMIC, "coulomb"):
        low, high = BOX[name]
        values = (np.array([getattr(point, name) for point in points]) - low) / (high - low)
        assert np.all((values >= 0.0) & (values <= 1.0))
        assert np.all(np.abs(np.histogram(values, 8, (0.0, 1.0))[0] - 32) <= 6)


def test_search_climbs_to_a_norm_that_the_points_do_not_have() -> None:
    found = worst_norm(minimax_controller(), plant(), interior_points(BOX, 8, 1))
    climbed = searched(minimax_controller(), plant(), BOX, found)
    assert climbed.norm > found.norm
    assert worst_norm(minimax_controller(), plant(), [climbed.point]).norm == climbed.norm


def test_worst_of_the_vertices_is_the_published_one() -> None:
    worst = worst_norm(minimax_controller(), plant(), CLUTCH.vertices)
    assert abs(worst.norm / 0.8872 - 1.0) < 5e-4  # the coefficients are given to four digits
