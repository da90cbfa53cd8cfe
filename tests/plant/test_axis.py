"""The axis parameters: order of the array, breakaway never below Coulomb friction, what is out of
range is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

from frictool.plant import axis
from frictool.plant.axis import STATE_SIZE, AxisParameters, rest

GOOD = AxisParameters(inertia=1.0, viscous=0.1, coulomb=1.0, breakaway=1.2)


def test_each_index_names_its_field() -> None:
    *names, last = AxisParameters._fields
    assert last == "laws"
    for index, name in enumerate(names):
        assert getattr(axis, name.upper()) == index


def test_array_holds_the_fields() -> None:
    np.testing.assert_array_equal(GOOD.as_array(), np.array(GOOD[:-1]))


def test_breakaway_is_lifted_to_the_coulomb_friction() -> None:
    lifted = GOOD._replace(breakaway=0.5, backlash_coulomb=0.3).checked()
    assert (lifted.breakaway, lifted.backlash_breakaway) == (1.0, 0.3)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("inertia", 0.0),
        ("inertia", -1.0),
        ("viscous", -0.1),
        ("lag", math.inf),
        ("constant", math.nan),
        ("drive_limit", 0.0),
    ],
)
def test_out_of_range_is_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        GOOD._replace(**{name: value}).as_array()


def test_rest_state() -> None:
    state = rest(2.0, 0.5)
    assert state.shape == (STATE_SIZE,)
    assert (
        state[axis.POSITION],
        state[axis.LOAD_POSITION],
        state[axis.DRIVE],
        state[axis.GAP],
    ) == (2.0, 2.0, 0.5, 0.0)
