"""Units of an angular motion name an angle: 1 Hz can be one turn or one radian per second."""

from __future__ import annotations

import math

import pytest

from frictool.documents.quantity import factor_to_si


@pytest.mark.parametrize(
    ("unit", "dimension", "write"),
    [
        ("Hz", "velocity", "rev/s for turns, or unit: rad/s"),
        ("1/s", "velocity", "rev/s for turns, or unit: rad/s"),
        ("kHz/s", "acceleration", "rev/s^2 for turns, or unit: rad/s^2"),
        ("%", "position", "rev for turns, or unit: rad"),
    ],
)
def test_a_unit_without_an_angle_is_refused(unit: str, dimension: str, write: str) -> None:
    with pytest.raises(ValueError, match=r"names no angle, and may mean") as caught:
        factor_to_si(unit, dimension, "rotary")
    assert f"write unit: {write}" in str(caught.value)


@pytest.mark.parametrize("unit", ["rev", "turn", "revolution", "cycle"])
def test_a_turn_has_2_pi_radians(unit: str) -> None:
    assert factor_to_si(unit, "position", "rotary") == pytest.approx(2.0 * math.pi, rel=1e-15)
    assert factor_to_si(f"{unit}/s", "velocity", "rotary") == pytest.approx(
        60.0 * factor_to_si("rpm", "velocity", "rotary"), rel=1e-14
    )


def test_a_frequency_is_no_unit_of_a_linear_motion() -> None:
    with pytest.raises(ValueError, match="does not measure velocity of a linear axis"):
        factor_to_si("Hz", "velocity", "linear")


@pytest.mark.parametrize("unit", ["Grad", "grad", "Mrad", "GRAD/s"])
def test_an_angle_of_two_meanings_is_refused(unit: str) -> None:
    """`Grad` is German for degrees, and a giga-radian for the units library."""
    dimension = "velocity" if "/" in unit else "position"
    with pytest.raises(ValueError, match="may mean degrees, gradians"):
        factor_to_si(unit, dimension, "rotary")


@pytest.mark.parametrize("unit", ["mrad", "krad", "gon", "deg"])
def test_other_angles_are_read(unit: str) -> None:
    expected = {"mrad": 1e-3, "krad": 1e3, "gon": math.pi / 200.0, "deg": math.pi / 180.0}
    assert factor_to_si(unit, "position", "rotary") == pytest.approx(expected[unit], rel=1e-15)
