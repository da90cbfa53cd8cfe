"""Plant variants of a simulated axis: nominal, vertices of the ranges, random, or chosen values.

The ranges of inertia, viscous friction, Coulomb friction and drive constant are those that `synth`
uses (`ranges` of adapters/parameter_intervals.py). At a vertex, each of these four parameters is at
one end of its range. In a random plant, each parameter is drawn uniformly from its range,
independently of the others. If more plants are drawn with the same seed, the first plants stay the
same. adapters/friction_levels.py applies the four values to models with additional friction
parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.axis_dynamic_law import dynamic_law_of
from frictool.adapters.axis_model import axis_of
from frictool.adapters.friction_levels import coulomb_level, viscous_level
from frictool.adapters.parameter_intervals import hull, ranges
from frictool.documents.model import Model
from frictool.documents.quantity import drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.engine.dynamic_law_axis import with_contact, with_dynamic_law
from frictool.errors import FrictoolError
from frictool.logs.log import MAIN_TOPIC
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_dynamic_law import AxisDynamicLaw
from frictool.plant.polytope import PARAMETERS, PlantPoint, corner_points
from frictool.simulate.scenario_plant_values import GIVEN, given_values
from frictool.simulate.simulated_plant import VariedParameter

LABELS = {
    "inertia": "inertia",
    "viscous": "viscous friction",
    "coulomb": "Coulomb friction",
    "constant": "drive constant",
    "breakaway": "breakaway",
    "offset": "offset",
    "backlash": "backlash",
}
PLANTS_STREAM = 1 << 32  # stream number of the random plants of a seed; noise uses (seed, variant)


@dataclass(frozen=True)
class AxisVariant:
    """Plant with the parameters of one variant.

    `name`: name of the variant, empty for the nominal plant. `values`: parameters [SI] that differ
    from the nominal plant. `dynamic`: dynamic friction law; None for static friction.
    """

    name: str
    axis: AxisParameters
    values: dict[str, float] = field(default_factory=dict)
    dynamic: AxisDynamicLaw | None = None

    @property
    def topic(self) -> str:
        """Return the topic of the stream, `/axis` or `/axis/NAME`."""
        return f"{MAIN_TOPIC}/{self.name}" if self.name else MAIN_TOPIC

    @cached_property
    def array(self) -> NDArray[np.float64]:
        """Return the axis parameters as an array for the kernels."""
        array = self.axis.as_array()
        return array if self.dynamic is None else with_dynamic_law(array, self.dynamic)

    def rest(self, start: float) -> NDArray[np.float64]:
        """Return the initial state of the axis at rest at the position `start` [rad | m]."""
        state = rest(start)
        return state if self.dynamic is None else with_contact(state, self.dynamic)


def count(model: Model, scenario: Scenario) -> int:
    """Return the number of plants that a scenario simulates, including the nominal plant."""
    if scenario.variants == "vertices":
        return 1 + len(vertices(model))
    return 1 + (scenario.plants or 0) * (scenario.variants == "random")


def vertices(model: Model) -> tuple[PlantPoint, ...]:
    """Return a plant for each combination of range ends, named v01 to v16.

    The ranges are those of inertia, viscous friction, Coulomb friction and drive constant. If a
    parameter has no range, only one of the equal combinations is returned.
    """
    return corner_points(ranges(model))


def variants_of(
    model: Model,
    scenario: Scenario,
    owner: str = "model",
    parameters: Mapping[str, VariedParameter] | None = None,
) -> list[AxisVariant]:
    """Return the plants that the key `variants` of a scenario selects.

    The first plant is the nominal one; vertices or random plants follow. For `variants: given`, the
    only plant has the values under `given`. `owner` is the name of the model in messages.
    `parameters`: result of `parameters_of`, computed if None. Raises FrictoolError if a plant's
    parameters are out of range, or if plants must be drawn but no parameter has a range.
    """
    if scenario.variants == GIVEN:
        values = given_values(scenario, parameters or parameters_of(model))
        return [_variant(GIVEN, f"{owner} as given", model, values)]
    variants = [nominal_variant(model, owner)]
    if scenario.variants == "vertices":
        for vertex in vertices(model):
            values = {key: getattr(vertex, key) for key in PARAMETERS}
            variants.append(
                _variant(vertex.name, f"{owner} at vertex {vertex.name}", model, values)
            )
    if scenario.variants == "random":
        assert scenario.plants is not None
        for name, values in _drawn(model, scenario.plants, scenario.seed, owner).items():
            variants.append(_variant(name, f"{owner}, plant {name}", model, values))
    return variants


def nominal_variant(model: Model, owner: str = "model") -> AxisVariant:
    """Return the nominal plant; raise FrictoolError if a parameter is out of range."""
    return _variant("", owner, model, {})


def nominal_levels(model: Model) -> dict[str, float]:
    """Return the nominal values of the four varied parameters by name.

    The nominal value of a viscous or Coulomb friction is the middle of the parameter's interval.
    """
    coulomb, viscous = coulomb_level(model), viscous_level(model)
    values = (
        model.parameters.inertia.value,
        0.5 * sum(viscous),
        0.5 * sum(coulomb),
        model.bench.actuator.constant.value,
    )
    return dict(zip(PARAMETERS, values, strict=True))


def parameters_of(model: Model) -> dict[str, VariedParameter]:
    """Return the parameters of a model that a scenario can set or vary, by name.

    Inertia, viscous friction, Coulomb friction, drive constant, offset and backlash have the ranges
    of the model. The breakaway friction has no range: its ratio to the Coulomb friction is constant
    unless the scenario sets the breakaway friction.
    """
    bench = model.bench
    nominal = nominal_levels(model)
    drive = drive_dimension(bench.actuator.drive, constant=True)
    dimensions = {
        "inertia": "inertia",
        "viscous": "viscous",
        "coulomb": "effort",
        "constant": drive,
    }
    parameters = {
        name: VariedParameter(
            *ends, nominal[name], si_unit(dimensions[name], model.axis), LABELS[name]
        )
        for name, ends in ranges(model).items()
    }
    effort, position = si_unit("effort", model.axis), si_unit("position", model.axis)
    breakaway = model.parameters.breakaway.value
    offset = model.parameters.offset
    backlash = bench.mechanics.backlash
    # mean Coulomb friction, which differs from the model's parameter if the friction depends on
    # position or direction
    level = nominal["coulomb"]
    least = ("coulomb", model.parameters.coulomb.value / level) if level > 0.0 else None
    parameters["breakaway"] = VariedParameter(
        breakaway, breakaway, breakaway, effort, LABELS["breakaway"], least
    )
    ends = hull(offset) if bench.mechanics.offset is None else hull(offset, bench.mechanics.offset)
    parameters["offset"] = VariedParameter(*ends, offset.value, effort, LABELS["offset"])
    if backlash is not None:
        parameters["backlash"] = VariedParameter(
            *backlash.interval, backlash.value, position, LABELS["backlash"]
        )
    return parameters


def _drawn(model: Model, plants: int, seed: int, owner: str) -> dict[str, dict[str, float]]:
    box = ranges(model)
    if all(low == high for low, high in box.values()):
        raise FrictoolError(
            f"{owner}: variants: random needs ranges, but the bench has none; give low and "
            "high in bench.mechanics"
        )
    lows, highs = (np.array([box[name][side] for name in PARAMETERS]) for side in (0, 1))
    parts = np.random.Generator(np.random.PCG64([seed, PLANTS_STREAM])).random(
        (plants, len(PARAMETERS))
    )
    drawn = lows + parts * (highs - lows)
    width = len(str(plants))
    return {
        f"p{index:0{width}d}": dict(zip(PARAMETERS, map(float, row), strict=True))
        for index, row in enumerate(drawn, start=1)
    }


def _variant(name: str, owner: str, model: Model, values: dict[str, float]) -> AxisVariant:
    try:
        axis = axis_of(model, **values)
        return AxisVariant(name, axis, values, dynamic_law_of(model, axis))
    except ValueError as error:
        raise FrictoolError(f"{owner}: {error}") from None
