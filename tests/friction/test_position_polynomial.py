"""The least of a polynomial over a travel against a dense grid; what is kept of a map is what would
be found anew."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from frictool.friction.polynomial_minimum import minimum
from frictool.friction.position_polynomial import least_factor, normalise, normalised_coefficients
from frictool.plant.axis_friction_laws import (
    COULOMB_MAPS,
    DYNAMIC_SIZE,
    MAX_TERMS,
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    Sides,
)

GRID = np.linspace(-1.0, 2.0, 20001)
PADDED = st.lists(st.floats(-2, 2, allow_subnormal=False), min_size=1, max_size=MAX_TERMS).map(
    lambda b: [*b, 0.0, 0.0]
)


@given(PADDED, st.integers(0, 9000), st.integers(1, 10000))
@example(
    [0.0, 0.0, -1.0, 0.0, -1.0, -1.0, 1.0, 4.6e-52], 0, 1544
)  # of which eigenvalues find no turning point
def test_the_least_is_that_of_a_dense_grid(
    coefficients: list[float], first: int, count: int
) -> None:
    x = GRID[first : first + count + 1]
    curve = np.polynomial.Polynomial(coefficients)
    place, found = minimum(coefficients, x[0], x[-1])
    assert x[0] <= place <= x[-1]
    assert found == pytest.approx(curve(place), rel=1e-13, abs=1e-13)
    on_grid, bend = curve(x).min(), np.abs(curve.deriv(2)(GRID)).max()
    step = GRID[1] - GRID[0]
    assert on_grid - 0.5 * bend * step**2 - 1e-9 <= found <= on_grid + 1e-9


@given(st.floats(-1, 2), st.floats(-1, 2), st.floats(-300, 300))
def test_the_place_of_a_cubic_s_least_is_where_it_turns(
    turning: float, other: float, power: float
) -> None:
    """Coefficients may be of any size: those whose squares overflow or vanish count as any
    other."""
    assume(abs(turning - other) > 1e-3)
    scale = 10.0**power if turning > other else -(10.0**power)
    cubic = [scale * one for one in (0.0, turning * other, -0.5 * (turning + other), 1.0 / 3.0)]
    near = 0.5 * abs(turning - other)
    assert minimum(cubic, turning - near, turning + near)[0] == pytest.approx(turning, abs=1e-9)


@given(
    *[st.lists(st.floats(0.1, 2), min_size=1, max_size=5).map(tuple)] * 4,
    st.floats(0, 3),
    st.floats(0, 3),
)
def test_what_is_kept_of_a_map_changes_no_bit(
    forward: tuple, backward: tuple, up: tuple, down: tuple, slip: float, more: float
) -> None:
    over, levels = (0.0, 3.0), AxisFrictionLevels(0.0, slip, slip + more)
    for sides in ((forward, backward), (up, down)):
        for terms in sides:
            np.testing.assert_array_equal(
                normalised_coefficients(terms, *over), normalise(np.array(terms), *over)[0]
            )
            assert least_factor(terms, *over) == minimum(
                normalised_coefficients(terms, *over), *over
            )
    slips, rests = (_written((backward, forward), value) for value in (slip, slip + more))
    packed = np.concatenate(
        [
            np.zeros(14),
            AxisLaws(
                shape=FrictionPositionShape(*over, (forward, backward), (forward, backward))
            ).pack(levels),
        ]
    )
    kept = packed[COULOMB_MAPS:DYNAMIC_SIZE]
    np.testing.assert_array_equal(kept, np.concatenate([*slips, *rests]))


def _written(sides: Sides, value: float) -> list[np.ndarray]:
    found = [value * normalise(np.array(terms), 0.0, 3.0)[0] for terms in sides]
    return [np.concatenate([row, np.zeros(MAX_TERMS - row.size)]) for row in found]


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=4), st.floats(0.5, 2), st.floats(0, 0.5))
def test_friction_that_its_map_takes_below_zero_is_refused(
    terms: list[float], slip: float, more: float
) -> None:
    """Slip and rest may share a map or have two equal ones: both are judged alike."""
    curve, over = (1.5, *terms), (0.0, 2.0)
    assume(_mean(curve) > 0.1)
    smallest = minimum(normalised_coefficients(curve, *over), *over)[1]
    assume(abs(smallest) > 1e-9)
    for rests in (curve, (*curve, 0.0)):
        laws = AxisLaws(shape=FrictionPositionShape(*over, (curve, curve), (rests, rests)))
        if smallest < 0.0:
            with pytest.raises(ValueError, match="Coulomb friction backward is -"):
                laws.pack(AxisFrictionLevels(0.0, slip, slip + more))
        else:
            laws.pack(AxisFrictionLevels(0.0, slip, slip + more))


def _mean(curve: tuple[float, ...]) -> float:
    whole = np.polynomial.Polynomial(curve).integ()
    return float(whole(2.0) - whole(0.0)) / 2.0
