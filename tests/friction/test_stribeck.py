"""The speed from which on the curve of (2.34) is Coulomb friction to rounding."""

from __future__ import annotations

import math

import pytest

from frictool.friction.stribeck import straight_from


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("velocity", [0.01, 12.0])
def test_the_fall_is_below_rounding_there_and_not_well_before(
    velocity: float, exponent: float
) -> None:
    speed = straight_from(velocity, exponent)
    assert 1.0 + math.exp(-((speed / velocity) ** exponent)) == 1.0
    before = speed * 0.93 ** (1.0 / exponent)
    assert 1.0 + math.exp(-((before / velocity) ** exponent)) > 1.0
