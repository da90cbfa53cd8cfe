"""The plants that a scenario is played to: the model, the vertices of its ranges, plants drawn at
random, or a given one.

The ranges of inertia, viscous and Coulomb friction and constant are `ranges` of plant/polytope.py,
for which `synth` designs too. A vertex has an end of each range; a random plant is drawn from them
independently and uniformly. Plant number i of a seed is the same however many there are.

A vertex and a drawn plant are four numbers; plant/friction_levels.py applies them to models with
further friction parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from frictool.documents.model import Model
from frictool.documents.quantity import drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.errors import FrictoolError
from frictool.logs.log import MAIN_TOPIC
from frictool.plant.axis import AxisParameters
from frictool.plant.axis_model import axis_of
from frictool.plant.friction_levels import coulomb_level, viscous_level
from frictool.plant.polytope import PARAMETERS, PlantPoint, corner_points, hull, ranges
from frictool.simulate.given_plant import GIVEN, given_values
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
PLANTS_STREAM = 1 << 32  # beside the seed: noise is drawn from (seed, variant)


@dataclass(frozen=True)
class AxisVariant:
    """One plant, `name` empty for the nominal one, and what makes it differ from that one; `topic`
    is that of its stream."""

    name: str
    axis: AxisParameters
    values: dict[str, float] = field(default_factory=dict)

    @property
    def topic(self) -> str:
        """`/axis`, or `/axis/NAME`."""
        return f"{MAIN_TOPIC}/{self.name}" if self.name else MAIN_TOPIC

    @cached_property
    def array(self) -> NDArray[np.float64]:
        """The axis for the kernels."""
        return self.axis.as_array()


def count(model: Model, scenario: Scenario) -> int:
    """How many variants there are, the nominal one among them."""
    if scenario.variants == "vertices":
        return 1 + len(vertices(model))
    return 1 + (scenario.plants or 0) * (scenario.variants == "random")


def vertices(model: Model) -> tuple[PlantPoint, ...]:
    """Return the corners of the model's ranges, v01 to v16 if all four have a width."""
    return corner_points(ranges(model))


def variants_of(
    model: Model,
    scenario: Scenario,
    owner: str = "model",
    parameters: Mapping[str, VariedParameter] | None = None,
) -> list[AxisVariant]:
    """Return the nominal plant and the requested vertices or random plants of the model, or else
    the one plant of the scenario.

    owner: the model as messages name it; parameters: the result of `parameters_of`, if known.
    Raises FrictoolError where a plant's parameters are out of range, or there is no range to draw
    from.
    """
    if scenario.variants == GIVEN:
        values = given_values(scenario, parameters or parameters_of(model))
        return [AxisVariant(GIVEN, _axis(f"{owner} as given", model, **values), values)]
    found = [AxisVariant("", _axis(owner, model))]
    if scenario.variants == "vertices":
        for vertex in vertices(model):
            values = {key: getattr(vertex, key) for key in PARAMETERS}
            found.append(
                AxisVariant(
                    vertex.name, _axis(f"{owner} at vertex {vertex.name}", model, **values), values
                )
            )
    if scenario.variants == "random":
        assert scenario.plants is not None
        for name, values in _drawn(model, scenario.plants, scenario.seed, owner).items():
            found.append(
                AxisVariant(name, _axis(f"{owner}, plant {name}", model, **values), values)
            )
    return found


def scheduled_values(model: Model, variant: AxisVariant) -> dict[str, float]:
    """PARAMETERS of a variant's plant [SI], as what a scheduled controller is told of it; of a
    range its middle."""
    return {name: variant.values.get(name, value) for name, value in _levels(model).items()}


def _levels(model: Model) -> dict[str, float]:
    """PARAMETERS of the model itself."""
    coulomb, viscous = coulomb_level(model), viscous_level(model)
    values = (
        model.parameters.inertia.value,
        0.5 * sum(viscous),
        0.5 * sum(coulomb),
        model.bench.actuator.constant.value,
    )
    return dict(zip(PARAMETERS, values, strict=True))


def parameters_of(model: Model) -> dict[str, VariedParameter]:
    """What of a model may be given or varied: PARAMETERS in their `ranges`, offset, backlash,
    breakaway.

    The breakaway has no range of its own: it goes with the Coulomb friction, of which it is a
    multiple, unless it is given.
    """
    bench, nominal = model.bench, _levels(model)
    drive = drive_dimension(bench.actuator.drive, constant=True)
    dimensions = {
        "inertia": "inertia",
        "viscous": "viscous",
        "coulomb": "effort",
        "constant": drive,
    }
    found = {
        name: VariedParameter(
            *ends, nominal[name], si_unit(dimensions[name], model.axis), LABELS[name]
        )
        for name, ends in ranges(model).items()
    }
    effort, position = si_unit("effort", model.axis), si_unit("position", model.axis)
    breakaway, offset, backlash = (
        model.parameters.breakaway.value,
        model.parameters.offset,
        bench.mechanics.backlash,
    )
    level = nominal[
        "coulomb"
    ]  # of which the parameter is a part where the model has a map, or its own friction backward
    least = ("coulomb", model.parameters.coulomb.value / level) if level > 0.0 else None
    found["breakaway"] = VariedParameter(
        breakaway, breakaway, breakaway, effort, LABELS["breakaway"], least
    )
    ends = hull(offset) if bench.mechanics.offset is None else hull(offset, bench.mechanics.offset)
    found["offset"] = VariedParameter(*ends, offset.value, effort, LABELS["offset"])
    if backlash is not None:
        found["backlash"] = VariedParameter(
            *backlash.interval, backlash.value, position, LABELS["backlash"]
        )
    return found


def _drawn(model: Model, plants: int, seed: int, owner: str) -> dict[str, dict[str, float]]:
    """Name -> the parameters of each plant."""
    box = ranges(model)
    if all(low == high for low, high in box.values()):
        raise FrictoolError(
            f"{owner}: variants: random draws from ranges, and its bench gives none; give low and high in bench.mechanics"
        )
    lows, highs = (np.array([box[name][side] for name in PARAMETERS]) for side in (0, 1))
    parts = np.random.Generator(np.random.PCG64([seed, PLANTS_STREAM])).random(
        (plants, len(PARAMETERS))
    )
    drawn, width = lows + parts * (highs - lows), len(str(plants))
    return {
        f"p{index:0{width}d}": dict(zip(PARAMETERS, map(float, row), strict=True))
        for index, row in enumerate(drawn, start=1)
    }


def _axis(owner: str, model: Model, **values: float) -> AxisParameters:
    try:
        return axis_of(model, **values)
    except ValueError as error:
        raise FrictoolError(f"{owner}: {error}") from None
