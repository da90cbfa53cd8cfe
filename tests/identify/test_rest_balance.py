"""Rests in which the measured effort would move an axis, according to its model."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate, Quantity, Span, si_unit
from frictool.documents.valid_side import ValidSide
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rest_balance import held_rest_warnings
from tests.support.linear_axis import PERIOD
from tests.support.loaded_axis import COUNT, rotary_bench

TRUTH = {"inertia": 5.0, "viscous": 12.0, "coulomb": 8.0, "offset": 3.0}
DIMENSIONS = ("inertia", "viscous", "effort", "effort")


def model() -> Model:
    """Return an axis with a Coulomb friction of 8 N m and a breakaway of at most 10 N m."""
    one = {
        name: Estimate(value, unit=si_unit(dimension, "rotary"), source="identified")
        for (name, value), dimension in zip(TRUTH.items(), DIMENSIONS, strict=True)
    }
    breakaway = Estimate(9.0, 8.0, 10.0, "N m", source="assumed")
    parameters = Parameters(**one, breakaway=breakaway)
    return Model(
        "model/1", "arm", "rotary", "coulomb", "auto", 0.95, rotary_bench(None), parameters,
        Provenance("test", "0"),
    )  # fmt: skip


def rested(effort: float, fast: bool = False) -> MotionRecord:
    """Return a record of a motion to 1 rad, a rest under an `effort` [N m], and a motion back.

    fast: True if the axis stops from 3.3 rad/s within an encoder count.
    """
    s = np.linspace(0.0, 1.0, 300)
    way = s if fast else s**2 * (3.0 - 2.0 * s)
    x = np.concatenate((way, np.full(400, 1.0), way[::-1]))
    u = np.concatenate((np.full(300, 23.0), np.full(400, effort), np.full(300, -20.0)))
    time = np.arange(x.size) * PERIOD
    return make_record("rig/log.csv", time, np.round(x / COUNT) * COUNT, u, COUNT, 0.0)


@pytest.mark.parametrize(("effort", "held"), [(12.0, False), (-6.0, False), (25.0, True)])
def test_friction_holds_the_axis_up_to_its_breakaway(effort: float, held: bool) -> None:
    """An effort of 22 N m without the offset exceeds breakaway and effort error."""
    warnings = held_rest_warnings(model(), [rested(effort)])
    assert bool(warnings) == held
    for one in warnings:
        assert one.startswith("log.csv: the axis rests at 1 rad under 21.8 N m, above the model's")
        assert len(one) <= 190


def test_an_effort_that_only_stops_the_axis_holds_nothing() -> None:
    """At 3.3 rad/s before and after 0.4 s, the momentum of 5 kg m^2 may take 83 N m."""
    assert not held_rest_warnings(model(), [rested(-50.0, fast=True)])
    assert held_rest_warnings(model(), [rested(-50.0)])


def test_ends_of_the_travel_and_the_other_side_of_a_kink_are_left_out() -> None:
    one, record = model(), rested(25.0)
    mechanics = msgspec.structs.replace(one.bench.mechanics, travel=Span(0.0, 1.0, "rad"))
    stopped = msgspec.structs.replace(one.bench, mechanics=mechanics)
    assert not held_rest_warnings(msgspec.structs.replace(one, bench=stopped), [record])
    below = ValidSide("below", Quantity(0.9, 0.8, 0.95, "rad"))
    assert not held_rest_warnings(msgspec.structs.replace(one, valid_side=below), [record])
