"""The engine's axis as a model.yaml describes it, at the nominal values and at a vertex."""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.adapters.friction_levels import coulomb_level, viscous_level
from frictool.adapters.parameter_intervals import intervals
from frictool.documents.bench import Mechanics
from frictool.documents.laws import Backward, Regime
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.registry import load
from frictool.engine.axis_friction import breakaway_at, coulomb_at
from frictool.plant.axis_friction_laws import PLAIN_SIZE
from studies.rigs.clutch_friction import TABLE_4_7
from studies.rigs.clutch_model import ROOT, clutch_model

NONLINEAR = ROOT / "configs/clutch/nonlinear.yaml"


def _with_mechanics(**fields: Quantity | None) -> Model:
    model = clutch_model()
    mechanics = msgspec.structs.replace(model.bench.mechanics, **fields)
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics)
    )


def test_takes_every_parameter_from_model_and_bench() -> None:
    axis = axis_of(clutch_model())
    named = dict(zip(axis._fields, axis.numbers, strict=False))
    assert named == pytest.approx(
        {
            "inertia": 1.32e-5, "viscous": 3.81e-4, "coulomb": 0.099, "breakaway": 0.1089,
            "offset": 0.0, "constant": 13.4e-3,
            "lag": 3e-3, "drive_limit": 50.0, "backlash": 3.0, "backlash_coulomb": 0.05,
            "backlash_breakaway": 0.055,
            "encoder_step": 2 * math.pi / 56, "resistance": 0.0, "supply": math.inf,
        }
    )  # fmt: skip


def test_breakaway_keeps_its_ratio_at_a_vertex() -> None:
    axis = axis_of(clutch_model(), coulomb=0.18, inertia=1.53e-5)
    assert (axis.coulomb, axis.breakaway, axis.inertia) == pytest.approx((0.18, 0.198, 1.53e-5))
    assert axis_of(clutch_model(), coulomb=0.18, breakaway=0.3).breakaway == 0.3


def test_friction_inside_the_backlash_is_no_more_than_the_axis_has() -> None:
    axis = axis_of(_with_mechanics(backlash_coulomb=Quantity(value=0.2, unit="N m")))
    assert (axis.backlash_coulomb, axis.backlash_breakaway) == pytest.approx((0.099, 0.1089))
    unknown = axis_of(_with_mechanics(backlash_coulomb=None))
    assert unknown.backlash_coulomb == unknown.coulomb


def test_no_backlash_without_one_in_the_bench() -> None:
    assert axis_of(_with_mechanics(backlash=None)).backlash == 0.0


def test_out_of_range_is_named() -> None:
    with pytest.raises(ValueError, match="inertia"):
        axis_of(clutch_model(), inertia=0.0)


def test_the_end_stops_are_those_of_the_travel() -> None:
    assert axis_of(clutch_model()).laws.stops == (0.0, 63.0)
    model = clutch_model()
    without = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=_without_travel(model))
    )
    assert axis_of(without).as_array().shape == (PLAIN_SIZE,)


def _without_travel(model: Model) -> Mechanics:
    return msgspec.structs.replace(model.bench.mechanics, travel=None)


@pytest.mark.parametrize(
    ("direction", "x"), [(1.0, 0.0), (1.0, 30.0), (1.0, 63.0), (-1.0, 6.24), (-1.0, 35.7)]
)
def test_the_published_clutch_has_the_published_breakaway(direction: float, x: float) -> None:
    """Table 4.7, and C_r = C_s/1.1 (4.42), to the digits of the file."""
    expected = sum(b * x**k for k, b in enumerate(TABLE_4_7[direction]))
    array = axis_of(load(NONLINEAR, Model)).as_array()
    assert breakaway_at(array, direction, x, 0.0) == pytest.approx(expected, rel=1e-4)
    assert coulomb_at(array, direction, x) == pytest.approx(expected / 1.1, rel=1e-4)


def test_a_vertex_scales_the_map_and_keeps_its_knees() -> None:
    model = load(NONLINEAR, Model)
    today, vertex = axis_of(model), axis_of(model, coulomb=0.18, viscous=7.62e-4)
    assert 0.5 * (vertex.coulomb + vertex.laws.backward.coulomb) == pytest.approx(0.18, rel=1e-12)
    scale = vertex.coulomb / today.coulomb
    assert vertex.laws.backward.breakaway == pytest.approx(
        scale * today.laws.backward.breakaway, rel=1e-12
    )
    assert vertex.breakaway == pytest.approx(scale * today.breakaway, rel=1e-12)
    assert (vertex.viscous, vertex.laws.backward.viscous) == (0.0, 0.0)
    assert vertex.laws.regimes == ((260.0, 7.62e-4, 7.62e-4),)
    assert today.laws.regimes == ((260.0, 3.81e-4, 3.81e-4),)


def _viscous(value: float) -> Estimate:
    return Estimate(value=value, unit="N m s/rad", source="identified")


@pytest.mark.parametrize("own", [0.0, 2e-4])
def test_a_vertex_with_the_models_own_numbers_is_the_model(own: float) -> None:
    """For all laws: directions that differ, knees, a map over a part of the travel."""
    model = load(NONLINEAR, Model)
    laws = msgspec.structs.replace(
        model.laws,
        backward=msgspec.structs.replace(model.laws.backward, viscous=_viscous(1e-4)),
        regimes=(
            Regime(Quantity(value=90.0, unit="rad/s"), _viscous(5e-4), _viscous(3e-4)),
            *model.laws.regimes,
        ),
        position=msgspec.structs.replace(model.laws.position, over=Span(10.0, 40.0, "rad")),
    )
    changed = msgspec.structs.replace(
        model,
        laws=laws,
        parameters=msgspec.structs.replace(model.parameters, viscous=_viscous(own)),
    )
    for plant in (clutch_model(), model, changed):
        coulomb, viscous = (
            _middle(plant.parameters.coulomb, plant, coulomb_level),
            _middle(plant.parameters.viscous, plant, viscous_level),
        )
        again = axis_of(
            plant, coulomb=coulomb, viscous=viscous, inertia=1.32e-5, constant=13.4e-3
        ).as_array()
        np.testing.assert_allclose(again, axis_of(plant).as_array(), rtol=1e-12)


def _middle(own: Quantity, plant: Model, level: Callable[[Model], tuple[float, float]]) -> float:
    """The level of the model's values: that of its intervals where it has none."""
    low, high = level(plant)
    return own.value if plant.laws is None else 0.5 * (low + high)


def test_without_any_viscous_friction_a_vertex_has_it_at_every_speed() -> None:
    model = load(NONLINEAR, Model)
    regimes = tuple(
        msgspec.structs.replace(regime, viscous=_viscous(0.0)) for regime in model.laws.regimes
    )
    dry = msgspec.structs.replace(model, laws=msgspec.structs.replace(model.laws, regimes=regimes))
    vertex = axis_of(dry, viscous=7.62e-4)
    assert (vertex.viscous, vertex.laws.backward.viscous, vertex.laws.regimes[0][1:]) == (
        7.62e-4,
        7.62e-4,
        (7.62e-4, 7.62e-4),
    )


def test_everything_dry_scales_with_a_vertex_to_the_mean_of_its_map() -> None:
    """Read off the engine's own friction, by a sum over the travel; the map is given over a part of
    it, and is constant beyond."""
    model = load(NONLINEAR, Model)
    position = msgspec.structs.replace(model.laws.position, over=Span(10.0, 40.0, "rad"))
    for law in (model.laws.position, position):
        mapped = msgspec.structs.replace(
            model, laws=msgspec.structs.replace(model.laws, position=law)
        )
        today, vertex = axis_of(mapped), axis_of(mapped, coulomb=0.05)
        arrays, places = (today.as_array(), vertex.as_array()), (np.arange(6300) + 0.5) * 0.01
        mean = [
            np.mean([coulomb_at(array, side, x) for side in (-1.0, 1.0) for x in places])
            for array in arrays
        ]
        assert mean[1] == pytest.approx(0.05, rel=1e-6)
        scale = mean[1] / mean[0]
        for side in (-1.0, 1.0):
            for x in (0.0, 20.0, 63.0):
                assert coulomb_at(arrays[1], side, x) == pytest.approx(
                    scale * coulomb_at(arrays[0], side, x), rel=1e-6
                )
                assert breakaway_at(arrays[1], side, x, 0.0) == pytest.approx(
                    scale * breakaway_at(arrays[0], side, x, 0.0), rel=1e-6
                )
        assert vertex.backlash_coulomb == pytest.approx(scale * today.backlash_coulomb, rel=1e-6)
        assert vertex.backlash_breakaway == pytest.approx(
            scale * today.backlash_breakaway, rel=1e-6
        )


def test_the_polytope_holds_each_direction_and_regime() -> None:
    model = load(NONLINEAR, Model)
    assert intervals(model)["viscous"] == (0.0, 7.62e-4)
    strong = msgspec.structs.replace(model.laws.backward.coulomb, high=0.25)
    wider = msgspec.structs.replace(
        model,
        laws=msgspec.structs.replace(model.laws, backward=Backward(coulomb=strong), position=None),
    )
    assert intervals(wider)["coulomb"] == (0.018, 0.25)
