"""Coefficients as a number format holds them: near, exact where they are whole, and exactly what
fixed point multiplies by."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.controller import Number
from frictool.synth.realisation import running_in_sections
from frictool.verify.coefficient_rounding import coefficient_rounder, rounded_linear
from studies.rigs.example_controllers import speed_controller

NEAR = {"double": 0.0, "float": 2.0**-24, "q31": 2.0**-31, "q15": 2.0**-15}


@pytest.mark.parametrize("number", NEAR)
@given(value=st.floats(1e-3, 1e6), sign=st.sampled_from([-1.0, 1.0]))
def test_a_coefficient_is_held_to_its_bits(number: Number, value: float, sign: float) -> None:
    hold = coefficient_rounder(number)
    assert abs(hold(sign * value) - sign * value) <= NEAR[number] * value
    assert hold(hold(value)) == hold(value)
    assert hold(-value) == -hold(value)


@pytest.mark.parametrize("number", NEAR)
def test_an_integrator_stays_one(number: Number) -> None:
    assert [coefficient_rounder(number)(value) for value in (0.0, 1.0, -1.0)] == [0.0, 1.0, -1.0]


@pytest.mark.parametrize("number", ["float", "q31", "q15"])
def test_every_form_that_may_run_is_rounded(number: Number) -> None:
    linear = running_in_sections(speed_controller(), 1e-3)
    found, hold = rounded_linear(linear, number), coefficient_rounder(number)
    assert found != linear
    assert found.continuous == linear.continuous
    for form in ("sos", "anti_windup", "sos_anti_windup"):
        assert np.ravel(getattr(found, form)).tolist() == [
            hold(value) for value in np.ravel(getattr(linear, form))
        ]
    for part in "abcd":
        exact, rounded = (
            np.ravel(getattr(linear.discrete, part)),
            np.ravel(getattr(found.discrete, part)),
        )
        assert rounded.tolist() == [hold(value) for value in exact]
    assert rounded_linear(linear, "double") == linear
