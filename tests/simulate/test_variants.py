"""Plants drawn at random: from the bench's ranges, the same for a seed however many, and what their
friction map is."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.adapters.model_polytope import polytope
from frictool.adapters.parameter_intervals import intervals, ranges
from frictool.documents.laws import Backward, Laws
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.engine.axis_friction import breakaway_at, coulomb_at
from frictool.errors import FrictoolError
from frictool.plant.polytope import PARAMETERS
from frictool.simulate.axis_variants import AxisVariant, parameters_of, variants_of
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_scenario import scenario

TABLE_5_2 = {
    "inertia": (1.11e-5, 1.53e-5),
    "viscous": (0.0, 7.62e-4),
    "coulomb": (0.018, 0.180),
    "constant": (12.8e-3, 14.0e-3),
}


def nonlinear() -> Model:
    return load(ROOT / "configs/clutch/nonlinear.yaml", Model)


def drawn(plants: int, seed: int = 1, model: Model | None = None) -> list[AxisVariant]:
    return variants_of(
        model or clutch_model(), scenario(variants="random", plants=plants, seed=seed)
    )


def test_plants_fill_the_ranges_of_the_bench_independently() -> None:
    assert ranges(nonlinear()) == ranges(clutch_model()) == TABLE_5_2
    values = np.array(
        [[variant.values[name] for name in PARAMETERS] for variant in drawn(1000)[1:]]
    )
    lows, highs = (np.array([TABLE_5_2[name][side] for name in PARAMETERS]) for side in (0, 1))
    parts = (values - lows) / (highs - lows)
    assert parts.min() >= 0.0
    assert parts.max() <= 1.0
    counts = [np.histogram(column, bins=10, range=(0.0, 1.0))[0] for column in parts.T]
    assert np.max(np.abs(np.array(counts) - 100)) < 45  # 100 in each tenth, standard deviation 9.5
    assert np.max(np.abs(np.corrcoef(parts.T) - np.eye(4))) < 0.12  # standard deviation 0.03


def test_a_plant_of_a_seed_is_the_same_however_many_there_are() -> None:
    few, many, other = drawn(9), drawn(1000), drawn(9, seed=2)
    assert [variant.values for variant in few] == [variant.values for variant in many[:10]]
    assert all(a.values != b.values for a, b in zip(few[1:], other[1:], strict=True))
    assert [variant.topic for variant in few[:2]] == ["/axis", "/axis/p1"]
    assert many[-1].topic == "/axis/p1000"


def test_the_first_variant_is_the_model_itself() -> None:
    assert drawn(2)[0].values == {}
    assert drawn(2)[0].axis == variants_of(clutch_model(), scenario())[0].axis


def test_a_plant_has_what_was_drawn_and_the_map_scaled_to_it() -> None:
    """Mean over the travel and both directions, read off the engine's own friction."""
    today = nonlinear()
    arrays = [variant.axis.as_array() for variant in drawn(20, model=today)]
    places = (np.arange(630) + 0.5) * 0.1
    for variant, array in zip(drawn(20, model=today)[1:], arrays[1:], strict=True):
        assert (variant.axis.inertia, variant.axis.constant) == (
            variant.values["inertia"],
            variant.values["constant"],
        )
        mean = np.mean([coulomb_at(array, side, x) for side in (-1.0, 1.0) for x in places])
        assert mean == pytest.approx(variant.values["coulomb"], rel=1e-4)
        assert breakaway_at(array, 1.0, 31.0, 0.0) == pytest.approx(
            1.1 * coulomb_at(array, 1.0, 31.0), rel=1e-4
        )


def test_a_value_of_the_bench_without_a_range_widens_draws_and_certificate_alike() -> None:
    """Each direction's friction is in the range, which is that of the controller's vertices."""
    model = nonlinear()
    mechanics = msgspec.structs.replace(
        model.bench.mechanics,
        coulomb=Quantity(value=0.1, unit="N m"),
        inertia=Quantity(value=2e-5, unit="kg m^2"),
    )
    bare = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics)
    )
    found = parameters_of(bare)
    assert found["inertia"][:2] == (1.11e-5, 2e-5)
    assert {name: found[name][:2] for name in PARAMETERS} == ranges(bare)
    assert found["coulomb"].low == 0.1
    assert found["coulomb"].low < found["coulomb"].nominal < found["coulomb"].high
    for name, (low, high) in intervals(bare).items():
        assert low <= found[name].low <= found[name].high <= high


def test_vertices_of_a_model_with_friction_by_direction_are_those_of_its_controller() -> None:
    model = clutch_model()
    weak = msgspec.structs.replace(model.parameters.coulomb, value=0.25, low=0.24, high=0.27)
    two = msgspec.structs.replace(model, laws=Laws(backward=Backward(coulomb=weak)))
    vertices = variants_of(two, scenario(variants="vertices"))[1:]
    assert [one.values for one in vertices] == [
        {name: getattr(v, name) for name in PARAMETERS} for v in polytope(two).vertices
    ]
    assert max(one.values["coulomb"] for one in vertices) == 0.27


def test_no_range_to_draw_from_is_refused() -> None:
    model = clutch_model(coulomb=(0.1, 0.1, 0.1), constant=(0.0134, 0.0134, 0.0134))
    one = {
        name: Quantity(
            value=getattr(model.parameters, name).value,
            unit=getattr(model.bench.mechanics, name).unit,
        )
        for name in PARAMETERS[:3]
    }
    bench = msgspec.structs.replace(
        model.bench, mechanics=msgspec.structs.replace(model.bench.mechanics, **one)
    )
    fixed = {
        name: msgspec.structs.replace(getattr(model.parameters, name), low=None, high=None)
        for name in ("inertia", "viscous", "coulomb", "breakaway")
    }
    bare = msgspec.structs.replace(
        model, bench=bench, parameters=msgspec.structs.replace(model.parameters, **fixed)
    )
    with pytest.raises(
        FrictoolError, match=r"model: variants: random needs ranges.*give low and high"
    ):
        drawn(3, model=bare)
