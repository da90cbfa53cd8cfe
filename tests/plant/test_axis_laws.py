"""The laws of an axis in the kernels' array: what is out of range is named, what cannot be friction
is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from frictool.plant.axis import AxisParameters
from frictool.plant.axis_friction_laws import (
    BREAKAWAY_PAIR,
    COULOMB_PAIR,
    EXTENDED_SIZE,
    MAX_TERMS,
    PLAIN_SIZE,
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    ViscousRegime,
)

GOOD = AxisParameters(inertia=1.0, viscous=0.1, coulomb=1.0, breakaway=1.2)
FLAT = ((1.0,), (1.0,))


def test_no_laws_no_array() -> None:
    assert AxisLaws().pack(AxisFrictionLevels(0.1, 1.0, 1.2)).size == 0
    assert GOOD._replace(laws=AxisLaws()).as_array().shape == (PLAIN_SIZE,)


def test_each_side_has_its_levels_and_a_breakaway_of_at_least_its_coulomb_friction() -> None:
    array = GOOD._replace(laws=AxisLaws(backward=AxisFrictionLevels(0.2, 2.0, 1.5))).as_array()
    assert array.shape == (EXTENDED_SIZE,)
    np.testing.assert_array_equal(array[COULOMB_PAIR : COULOMB_PAIR + 2], [2.0, 1.0])
    np.testing.assert_array_equal(array[BREAKAWAY_PAIR : BREAKAWAY_PAIR + 2], [2.0, 1.2])


@pytest.mark.parametrize(
    ("laws", "words"),
    [
        (AxisLaws(backward=AxisFrictionLevels(0.1, -1.0, 1.0)), "backward coulomb is -1"),
        (AxisLaws(backward=AxisFrictionLevels(math.nan, 1.0, 1.0)), "backward viscous is nan"),
        (
            AxisLaws(regimes=(ViscousRegime(0.0, 1.0, 1.0),)),
            "a knee at 0; allowed: knees above 0 in rising order",
        ),
        (
            AxisLaws(regimes=(ViscousRegime(2.0, 1.0, 1.0), ViscousRegime(2.0, 1.0, 1.0))),
            "a knee at 2; allowed: knees above 0 in rising order",
        ),
        (AxisLaws(regimes=(ViscousRegime(2.0, 1.0, -1.0),)), "viscous beyond the knee at 2 is -1"),
        (
            AxisLaws(regimes=tuple(ViscousRegime(1.0 + k, 1.0, 1.0) for k in range(5))),
            "regimes: found 5; allowed: at most 4",
        ),
        (AxisLaws(stribeck_velocity=-1.0), "stribeck_velocity is -1"),
        (AxisLaws(stribeck_velocity=1.0, stribeck_exponent=0.1), "stribeck_exponent is 0.1"),
        (AxisLaws(rise_time=math.inf), "rise_time is inf"),
        (AxisLaws(fresh=0.0, rise_time=1.0), "fresh is 0; allowed: > 0"),
        (AxisLaws(stops=(1.0, 1.0)), "end stops at 1 and 1; allowed: low < high"),
        (AxisLaws(restitution=1.0), "restitution is 1; allowed: >= 0 and < 1"),
        (AxisLaws(shape=FrictionPositionShape(1.0, 0.0, FLAT, FLAT)), "travel low < high"),
        (
            AxisLaws(shape=FrictionPositionShape(0.0, 1.0, ((1.0, -3.0, 2.1), (1.0,)), FLAT)),
            "Coulomb friction forward is -0.*allowed: >= 0",
        ),
        (
            AxisLaws(shape=FrictionPositionShape(0.0, 1.0, FLAT, ((1.0,), (1.0, 1.0)))),
            "breakaway minus Coulomb friction backward is -0.2 at 0;",
        ),
        (
            AxisLaws(
                shape=FrictionPositionShape(0.0, 1.0, ((1.0,) * (MAX_TERMS + 1), (1.0,)), FLAT)
            ),
            "9 coefficients; allowed: at most 8",
        ),
    ],
)
def test_what_is_out_of_range_is_named(laws: AxisLaws, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        GOOD._replace(laws=laws).as_array()
