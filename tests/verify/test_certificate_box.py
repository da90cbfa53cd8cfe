"""Rectangles of rates that hold plants of a box, the strength of friction in them, and the coverage
of all of them by cells."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.certificate import Box, Cell
from frictool.verify.certificate_box import (
    Interval,
    friction_rates,
    inverse_inertia,
    surroundings,
    uncovered,
)

BOX = Box((1.11e-5, 1.53e-5), (-1e-4, 7.62e-4), (-0.05, 0.18), (12.8e-3, 14e-3))


def _plants(box: Box, seed: int, count: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.array(
        [
            random.uniform(*interval, count)
            for interval in (box.inertia, box.viscous, box.coulomb, box.constant)
        ]
    ).T


def _tiles(low: float, high: float, count: int) -> list[Interval]:
    marks = [Fraction(float(value)) for value in np.linspace(low, high, count + 1)]
    return list(itertools.pairwise(marks))


def _covering(box: Box, across: int, along: int) -> list[Cell]:
    (k_low, k_high), (s_low, s_high) = (
        (float(ends[0]), float(ends[1])) for ends in surroundings(box)
    )
    cells = []
    for drive in _tiles(k_low - 1.0, k_high + 1.0, across):
        for viscous in _tiles(s_low - 1.0, s_high + 1.0, along):
            if inverse_inertia(box, drive, viscous) is not None:
                ends = ((float(low), float(high)) for low, high in (drive, viscous))
                cells.append(Cell(*ends, at_low="", at_high=""))
    return cells


@given(seed=st.integers(0, 10**6), across=st.integers(1, 9), along=st.integers(1, 9))
@settings(max_examples=25, deadline=None)
def test_every_plant_is_in_a_rectangle_that_is_not_empty_and_its_friction_within_the_line(
    seed: int, across: int, along: int
) -> None:
    cells = _covering(BOX, across, along)
    assert uncovered(BOX, cells) is None
    for j, sigma, coulomb, constant in _plants(BOX, seed, 40):
        k, s = constant / j, sigma / j
        inside = [
            c
            for c in cells
            if c.drive_rate[0] <= k <= c.drive_rate[1]
            and c.viscous_rate[0] <= s <= c.viscous_rate[1]
        ]
        assert inside
        for cell in inside:
            rates = tuple(
                tuple(map(Fraction, ends)) for ends in (cell.drive_rate, cell.viscous_rate)
            )
            low, high = inverse_inertia(BOX, *rates)
            assert float(low) * (1.0 - 1e-12) <= 1.0 / j <= float(high) * (1.0 + 1e-12)
            place = (k - cell.drive_rate[0]) / (cell.drive_rate[1] - cell.drive_rate[0])
            first, last = map(float, friction_rates(BOX, *rates))
            assert abs(coulomb) / j <= (first + place * (last - first)) * (1.0 + 1e-12)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_an_empty_rectangle_holds_no_plant(seed: int) -> None:
    random = np.random.default_rng(seed)
    drive, viscous = sorted(random.uniform(800, 1300, 2)), sorted(random.uniform(-20, 80, 2))
    rates = tuple(tuple(map(Fraction, ends)) for ends in (drive, viscous))
    j, sigma, _, constant = _plants(BOX, seed, 4000).T
    k, s = constant / j, sigma / j
    if np.any((k > drive[0]) & (k < drive[1]) & (s > viscous[0]) & (s < viscous[1])):
        assert inverse_inertia(BOX, *rates) is not None


@pytest.mark.parametrize("removed", range(12))
def test_one_cell_less_leaves_plants_uncovered(removed: int) -> None:
    cells = _covering(BOX, 4, 3)
    del cells[removed % len(cells)]
    gap = uncovered(BOX, cells)
    assert gap is not None
    assert inverse_inertia(BOX, *gap) is not None


def test_a_wider_box_is_not_covered() -> None:
    cells = _covering(BOX, 3, 3)
    for name, wider in (
        ("inertia", (1.0e-5, 1.53e-5)),
        ("viscous", (-1e-4, 9e-4)),
        ("constant", (12.0e-3, 14e-3)),
    ):
        box = Box(
            **{
                **{key: getattr(BOX, key) for key in ("inertia", "viscous", "coulomb", "constant")},
                name: wider,
            }
        )
        assert uncovered(box, cells) is not None


def test_parameters_that_are_known_exactly() -> None:
    point = Box((1e-5, 1e-5), (0.0, 0.0), (0.1, 0.1), (0.01, 0.01))
    assert uncovered(point, [Cell((999.0, 1001.0), (-1.0, 1.0), "", "")]) is None
    assert uncovered(point, [Cell((1000.5, 1001.0), (-1.0, 1.0), "", "")]) is not None
    assert uncovered(point, []) is not None


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"inertia": (0.0, 1.0)}, "inertia"),
        ({"viscous": (1.0, 0.0)}, "low <= high"),
        ({"constant": (1.0,)}, "constant"),
    ],
)
def test_a_box_that_is_none_is_refused(change: dict[str, tuple[float, ...]], told: str) -> None:
    whole = {
        "inertia": (1.0, 2.0),
        "viscous": (0.0, 1.0),
        "coulomb": (0.0, 1.0),
        "constant": (1.0, 2.0),
    }
    with pytest.raises(ValueError, match=told):
        Box(**{**whole, **change})
