"""Friction over position: the order that the data ask for, and whether the directions differ."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.identify.breakaway.position_law import (
    BreakawayPositions,
    PolynomialOrders,
    choose_structure,
    fit_polynomials,
    sides_of,
)
from studies.rigs.clutch_friction import BACKWARD, FORWARD

NOISE = 1e-3  # N m


def places(seed: int, count: int = 40) -> BreakawayPositions:
    generator = np.random.default_rng(seed)
    position = np.concatenate([np.sort(generator.uniform(2.0, 61.0, count)) for _ in range(2)])
    return BreakawayPositions(
        position, np.repeat([1.0, -1.0], count), float(position.min()), float(position.max())
    )


def friction(
    where: BreakawayPositions,
    forward: list[float],
    backward: list[float],
    seed: int,
    noise: float = NOISE,
) -> np.ndarray:
    curve = np.polynomial.polynomial.polyval
    exact = np.where(
        where.direction > 0.0,
        curve(where.position, np.array(forward)),
        curve(where.position, np.array(backward)),
    )
    return exact + noise * np.random.default_rng([seed, 1]).standard_normal(exact.size)


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=6))
def test_powers_are_weighted_sums_of_the_coefficients(coefficients: list[float]) -> None:
    where, value = places(3), np.array(coefficients)
    weights = where.power_weights(np.eye(value.size))
    found = np.polynomial.polynomial.polyval(where.position, weights @ value)
    assert found == pytest.approx(np.polynomial.legendre.legval(where.scaled, value), abs=1e-9)


def test_table_4_7_has_a_cubic_forward_and_a_quartic_backward() -> None:
    where = places(1)
    structure = choose_structure(where, friction(where, FORWARD, BACKWARD, 1))
    assert structure == PolynomialOrders((3, 4), common=False)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_exact_polynomials_come_back(seed: int) -> None:
    where = places(seed)
    exact = friction(where, FORWARD, BACKWARD, seed, noise=0.0)
    solution = fit_polynomials(where, exact, PolynomialOrders((3, 4), common=False))
    for found, true in zip(
        map(where.powers, sides_of(PolynomialOrders((3, 4), common=False), solution.value)),
        (FORWARD, BACKWARD),
        strict=True,
    ):
        assert found == pytest.approx(true, rel=1e-6)
    curve = np.polynomial.polynomial.polyval(
        np.linspace(where.low, where.high, 20_001), np.array(FORWARD)
    )
    assert solution.value[0] == pytest.approx(
        np.mean(curve), rel=1e-4
    )  # the first coefficient is the mean over the range


def test_a_constant_is_left_a_constant() -> None:
    """With an offset: |effort| differs between the directions by a constant, which is no reason for
    two polynomials."""
    simple = 0
    for seed in range(40):
        where = places(seed)
        simple += choose_structure(where, friction(where, [0.113], [0.105], seed)).constant
    assert simple >= 34


def test_a_common_shape_with_an_offset() -> None:
    where = places(5)
    shifted = [FORWARD[0] - 0.01, *FORWARD[1:]]
    assert choose_structure(where, friction(where, FORWARD, shifted, 5)) == PolynomialOrders(
        (3, 3), common=True
    )


def test_one_direction() -> None:
    where = places(6)
    forward = where.direction > 0.0
    one = BreakawayPositions(
        where.position[forward], where.direction[forward], where.low, where.high
    )
    assert choose_structure(one, friction(where, FORWARD, FORWARD, 6)[forward]).orders == (3, -1)
