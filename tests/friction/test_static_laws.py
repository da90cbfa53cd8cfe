"""Static laws: equal to the printed equations, odd, dissipative, with the right derivative and
limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.friction.karnopp import seen_velocity
from frictool.friction.law import StaticKernels
from frictool.friction.law_registry import LAWS
from frictool.friction.static_kernels import sticking_force
from frictool.friction.stribeck import slip_slope
from studies.rigs.table_3_1 import TABLE_3_1, packed
from tests.support.law_drivers import pointers, static_values
from tests.support.law_values import values
from tests.support.plain_laws import sign, static_force

STATIC = sorted(name for name, law in LAWS.items() if law.kind == "static")
FORCE, BREAKAWAY, BAND, SEEN = range(4)


def at(name: str, velocities: list[float], q: dict[str, float]) -> np.ndarray:
    kernels = LAWS[name].kernels
    assert isinstance(kernels, StaticKernels)
    return static_values(*pointers(kernels), np.array(velocities), packed(LAWS[name], q))


@pytest.mark.parametrize("name", STATIC)
@given(data=st.data(), exponent=st.floats(-8.0, 3.0))
def test_slip_follows_the_equation_opposes_the_motion_and_is_odd(
    name: str, data: st.DataObject, exponent: float
) -> None:
    q, v = data.draw(values(LAWS[name])), 10.0**exponent
    forward, backward = at(name, [v, -v], q)
    assert math.isclose(forward[FORCE], static_force(name, v, q), rel_tol=1e-12)
    assert forward[FORCE] == -backward[FORCE]
    assert forward[FORCE] * v >= 0.0


@given(data=st.data(), ratio=st.floats(0.05, 5.0))
def test_slope_of_stribeck_is_the_derivative(data: st.DataObject, ratio: float) -> None:
    q = data.draw(values(LAWS["stribeck"]))
    v = ratio * q["stribeck_velocity"]
    step = 1e-5 * v
    low, middle, high = at("stribeck", [v - step, v, v + step], q)
    found = (high[FORCE] - low[FORCE]) / (2 * step)
    rounding = 1e-15 * abs(middle[FORCE]) / step
    assert math.isclose(
        found,
        slope(v, q),
        rel_tol=1e-6,
        abs_tol=1e-6 * q["coulomb"] / q["stribeck_velocity"] + 4 * rounding,
    )
    assert slope(v, q) == slope(-v, q)


def slope(v: float, q: dict[str, float]) -> float:
    return float(slip_slope(v, 1.0, packed(LAWS["stribeck"], q)))


def test_slope_of_stribeck_at_rest_and_far_out() -> None:
    q = TABLE_3_1["stribeck"]
    assert slope(0.0, {**q, "stribeck_exponent": 0.5}) == -math.inf
    assert slope(0.0, {**q, "stribeck_exponent": 1.0}) == pytest.approx(0.4 - 0.5 / 1e-3, rel=1e-12)
    assert slope(0.0, {**q, "breakaway": 1.0, "stribeck_exponent": 0.5}) == 0.4
    assert slope(1e300, {**q, "stribeck_exponent": 4.0}) == 0.4


@pytest.mark.parametrize(("name", "reach"), [("coulomb_tanh", 20.0), ("coulomb_atan", 1e7)])
@given(velocity=st.floats(1e-6, 1e3), forward=st.booleans())
def test_regularised_laws_tend_to_coulomb(
    name: str, reach: float, velocity: float, forward: bool
) -> None:
    v = velocity if forward else -velocity
    row = at(name, [v], {"coulomb": 1.0, "smoothing_velocity": velocity / reach})[0]
    assert row[FORCE] == pytest.approx(sign(v), rel=1e-6)
    assert row[BREAKAWAY] == 0.0


@given(effort=st.floats(-10, 10), forward=st.floats(0, 5), backward=st.floats(0, 5))
def test_a_body_at_rest_is_held_up_to_its_breakaway(
    effort: float, forward: float, backward: float
) -> None:
    held = sticking_force(effort, forward, backward)
    limit = forward if effort > 0 else backward
    assert held == sign(effort) * min(abs(effort), limit)


@pytest.mark.parametrize("name", STATIC)
def test_breakaway_and_band_are_the_parameters(name: str) -> None:
    q, row = TABLE_3_1[name], at(name, [5e-4], TABLE_3_1[name])[0]
    assert row[BREAKAWAY] == (0.0 if LAWS[name].approximation else q.get("breakaway", q["coulomb"]))
    assert row[BAND] == q.get("band", 0.0)
    assert row[SEEN] == (0.0 if name == "karnopp" else 5e-4)


@given(v=st.floats(-1, 1), band=st.floats(1e-6, 0.5))
def test_karnopp_moves_outside_its_band_only(v: float, band: float) -> None:
    assert seen_velocity(v, np.array([1.0, 1.5, 0.4, band])) == (v if abs(v) > band else 0.0)


def test_stribeck_joins_breakaway_and_coulomb() -> None:
    near, far = at("stribeck", [1e-12, 1.0], TABLE_3_1["stribeck"])
    assert near[FORCE] == pytest.approx(1.5, rel=1e-9)
    assert far[FORCE] == pytest.approx(1.0 + 0.4, rel=1e-12)
