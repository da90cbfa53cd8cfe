"""Logs that no rig of the model can give."""

from __future__ import annotations

import pytest

from frictool.observe.rig_plausibility import implausible
from frictool.observe.wear_estimate import EstimateRange, WearEstimate
from frictool.observe.wear_limit import judge
from studies.rigs.clutch_fleet import clutch


def told(inertia: float, wear: float = 1.0, moves: int = 8) -> WearEstimate:
    one = EstimateRange(inertia, inertia - 0.01, inertia + 0.01)
    return WearEstimate(
        1.0,
        moves,
        EstimateRange(wear, wear - 0.01, wear + 0.01),
        scale=EstimateRange(1.0, 0.955, 1.045),
        others={"inertia": one},
    )


@pytest.mark.parametrize(
    "inertia", [0.8, 1.0, 1.25, 1.45]
)  # the bench: 0.84 to 1.16, and units differ
def test_what_units_differ_by_is_not_told(inertia: float) -> None:
    assert implausible(clutch(), told(inertia)) == ()


@pytest.mark.parametrize("inertia", [-1.0, 0.39, 2.0, 10.0])
def test_an_inertia_that_no_unit_has_is_told_with_what_to_look_at(inertia: float) -> None:
    (line,) = implausible(clutch(), told(inertia))
    assert f"{inertia:.3g} times the model's" in line
    assert "saturation" in line


def test_before_any_move_nothing_is_implausible() -> None:
    assert implausible(clutch(), told(10.0, moves=0)) == ()


def test_wear_below_zero_is_told_and_not_judged() -> None:
    found = told(1.0, wear=-1.0)
    assert "signs of position and drive" in implausible(clutch(), found)[0]
    verdict = judge(found, 1.25)
    assert verdict.exceeded is None
    assert "below 0" in verdict.reason
