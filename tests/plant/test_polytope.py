"""The polytope spans the model's and the bench's intervals."""

from __future__ import annotations

import itertools

from frictool.adapters.model_polytope import polytope
from frictool.adapters.parameter_intervals import intervals
from studies.rigs.clutch_model import clutch_model


def test_sixteen_vertices_of_table_5_2() -> None:
    box = polytope(clutch_model())
    corners = {(v.inertia, v.viscous, v.coulomb, v.constant) for v in box.vertices}
    expected = itertools.product(
        (1.11e-5, 1.53e-5), (0.0, 7.62e-4), (0.018, 0.180), (12.8e-3, 14.0e-3)
    )
    assert corners == set(expected)
    assert len({v.name for v in box.vertices}) == 16
    assert box.centre.inertia == 0.5 * (1.11e-5 + 1.53e-5)


def test_a_model_outside_the_bench_widens_the_polytope() -> None:
    model = clutch_model(coulomb=(0.185, 0.19, 0.195))
    assert intervals(model)["coulomb"] == (0.018, 0.195)


def test_an_interval_of_no_width_halves_the_vertices() -> None:
    assert len(polytope(clutch_model(constant=(0.0134, 0.0134, 0.0134))).vertices) == 8
