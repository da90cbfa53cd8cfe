"""The engine's axis as a model.yaml describes it, at the nominal values and at a vertex."""

from __future__ import annotations

import math

import msgspec
import pytest

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.plant.axis_model import axis_of
from tests.synth.example import clutch_model


def _with_mechanics(**fields: Quantity | None) -> Model:
    model = clutch_model()
    mechanics = msgspec.structs.replace(model.bench.mechanics, **fields)
    return msgspec.structs.replace(model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics))


def test_takes_every_parameter_from_model_and_bench() -> None:
    axis = axis_of(clutch_model())
    named = dict(zip(axis._fields, axis.numbers, strict=False))
    assert named == pytest.approx(
        {
            "inertia": 1.32e-5, "viscous": 3.81e-4, "coulomb": 0.099, "breakaway": 0.1089, "offset": 0.0, "constant": 13.4e-3,
            "lag": 3e-3, "drive_limit": 50.0, "backlash": 3.0, "backlash_coulomb": 0.05, "backlash_breakaway": 0.055,
            "encoder_step": 2 * math.pi / 56,
        }
    )  # fmt: skip


def test_breakaway_keeps_its_ratio_at_a_vertex() -> None:
    axis = axis_of(clutch_model(), coulomb=0.18, inertia=1.53e-5)
    assert (axis.coulomb, axis.breakaway, axis.inertia) == pytest.approx((0.18, 0.198, 1.53e-5))
    assert axis_of(clutch_model(), coulomb=0.18, breakaway=0.3).breakaway == 0.3


def test_friction_inside_the_backlash_is_no_more_than_the_axis_has() -> None:
    axis = axis_of(clutch_model(), coulomb=0.018)
    assert (axis.backlash_coulomb, axis.backlash_breakaway) == pytest.approx((0.018, 0.0198))
    unknown = axis_of(_with_mechanics(backlash_coulomb=None))
    assert unknown.backlash_coulomb == unknown.coulomb


def test_no_backlash_without_one_in_the_bench() -> None:
    assert axis_of(_with_mechanics(backlash=None)).backlash == 0.0


def test_out_of_range_is_named() -> None:
    with pytest.raises(ValueError, match="inertia"):
        axis_of(clutch_model(), inertia=0.0)
