"""Curves: the monotone cubic against scipy's, never beyond what two points span; a cam's product
within its stated error."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from frictool.plant.mechanism.curves import (
    PRODUCT_ERROR,
    CurveList,
    cam_push,
    curve_slope,
    curve_value,
    monotone_cubic,
)

points = st.lists(st.tuples(st.floats(0.01, 3.0), st.floats(-50.0, 50.0)), min_size=3, max_size=9)


@given(points)
def test_the_cubic_is_scipys_and_stays_within_its_points(steps: list[tuple[float, float]]) -> None:
    x = np.cumsum([step for step, _ in steps])
    y = np.round(
        np.array([value for _, value in steps]), 3
    )  # differences above rounding: whether secants change sign is then clear
    curve = monotone_cubic(x.tolist(), y.tolist())
    at = np.linspace(x[0], x[-1], 400)
    assert np.allclose(curve.value(at), PchipInterpolator(x, y)(at), rtol=1e-9, atol=1e-9)
    for low, high, a, b in zip(x, x[1:], y, y[1:], strict=False):
        inside = curve.value(np.linspace(low, high, 50))
        assert min(a, b) - 1e-9 <= inside.min() <= inside.max() <= max(a, b) + 1e-9
    assert curve.value(np.array([x[0] - 5.0, x[-1] + 5.0])).tolist() == [
        y[0],
        curve.value(x[-1:])[0],
    ]


def test_two_points_are_a_line() -> None:
    curve = monotone_cubic([1.0, 3.0], [4.0, 0.0])
    assert curve.value(np.array([0.0, 2.0, 9.0])).tolist() == [4.0, 2.0, 0.0]
    assert curve.slope(np.array([0.0, 2.0, 9.0])).tolist() == [0.0, -2.0, 0.0]


@settings(max_examples=settings.default.max_examples // 3)
@given(points, st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=6))
def test_a_cams_push_is_within_its_stated_error(
    steps: list[tuple[float, float]], angles: list[float]
) -> None:
    x = np.cumsum([step for step, _ in steps])
    force = monotone_cubic(x.tolist(), [abs(value) for _, value in steps])
    angle = monotone_cubic(np.linspace(x[0] - 0.5, x[-1] + 0.2, len(angles)).tolist(), angles)
    push = cam_push(force, angle)
    at = np.linspace(x[0] - 1.0, x[-1] + 1.0, 4001)
    exact = force.value(at) * np.tan(angle.value(at))
    assert np.max(np.abs(push.value(at) - exact)) <= 3.0 * PRODUCT_ERROR * max(
        np.max(np.abs(exact)), 1e-12
    )


def test_packed_curves_give_the_same_values() -> None:
    curves = CurveList()
    ours = [
        monotone_cubic([0.0, 1.0, 2.5], [0.0, 3.0, 2.0]),
        monotone_cubic([-1.0, 1.0], [5.0, 6.0]),
    ]
    assert [curves.add(curve) for curve in ours] == [0, 1]
    packed = curves.packed()
    assert packed.start.tolist() == [0, 2, 3]
    for number, curve in enumerate(ours):
        for x in (-3.0, -1.0, 0.3, 1.0, 1.7, 2.5, 8.0):
            assert curve_value(packed, number, x) == curve.value(np.array(x))
            assert curve_slope(packed, number, x) == curve.slope(np.array(x))
