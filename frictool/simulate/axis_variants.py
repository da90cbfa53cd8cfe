"""Plant variants of a simulated axis: nominal, vertices, random plants, or chosen values.

The ranges of inertia, viscous friction, Coulomb friction and drive constant are the result of
`ranges` (adapters/parameter_intervals.py), as in `synth`. At a vertex, each of these four
parameters is at one end of its range. In a random plant, each of the four is drawn uniformly from
its range, independently of the others. A breakaway with a range is drawn, too, from the part of the
range that is possible with the drawn Coulomb friction. At a vertex, the ratio of breakaway to
Coulomb friction is the model's ratio. A larger number of random plants with the same seed begins
with the same plants. adapters/friction_levels.py applies the values to models with additional
friction parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from frictool.adapters.axis_dynamic_law import dynamic_law_of
from frictool.adapters.axis_model import axis_of
from frictool.adapters.friction_levels import coulomb_level, least_breakaway, viscous_level
from frictool.adapters.parameter_intervals import (
    breakaway_interval,
    breakaway_ratio,
    hull,
    ranges,
)
from frictool.adapters.total_load import valid_total
from frictool.documents.model import Model
from frictool.documents.quantity import drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.engine.dynamic_law_axis import with_contact, with_dynamic_law
from frictool.errors import FrictoolError
from frictool.logs.log import MAIN_TOPIC
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_dynamic_law import AxisDynamicLaw
from frictool.plant.polytope import PARAMETERS, PlantPoint, corner_points
from frictool.simulate.parameter_order import drawn_above
from frictool.simulate.scenario_plant_values import GIVEN, given_values
from frictool.simulate.simulated_plant import VariedParameter
from frictool.typing import Vector

LABELS = {
    "inertia": "inertia",
    "viscous": "viscous friction",
    "coulomb": "Coulomb friction",
    "constant": "drive constant",
    "breakaway": "breakaway",
    "offset": "offset",
    "backlash": "backlash",
}
# stream numbers of the random plants of a seed; noise uses (seed, variant). The breakaway has its
# own stream, so that the other parameters do not depend on whether it has a range
PLANTS_STREAM, BREAKAWAY_STREAM = 1 << 32, (1 << 32) + 1
COULOMB = PARAMETERS.index("coulomb")


@dataclass(frozen=True)
class AxisVariant:
    """Plant with the parameters of one variant.

    - name: name of the variant, empty for the nominal plant
    - values: parameters [SI] that are set for this variant
    - dynamic: dynamic friction law; None for static friction
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
    """Return the number of plants that a scenario simulates.

    The nominal plant (or the plant under `given`) counts as 1. Vertices or random plants are added
    if the scenario selects them.
    """
    if scenario.variants == "vertices":
        return 1 + len(vertices(model))
    return 1 + (scenario.plants or 0) * (scenario.variants == "random")


def vertices(model: Model) -> tuple[PlantPoint, ...]:
    """Return the vertices of the parameter box: at most 16 plants, named v01, v02, ...

    At a vertex, the inertia, the viscous friction, the Coulomb friction and the drive constant are
    each at an end of their range. If a parameter has no range, some vertices are equal; equal
    vertices are returned once.
    """
    return corner_points(ranges(model))


def variants_of(
    model: Model,
    scenario: Scenario,
    owner: str = "model",
    parameters: Mapping[str, VariedParameter] | None = None,
) -> list[AxisVariant]:
    """Return the plants that the key `variants` of a scenario selects.

    For `variants: given`, the only plant has the values under `given`. Otherwise, the first plant
    is the nominal plant; vertices or random plants follow. `owner` is the name of the model in
    messages. `parameters`: result of `parameters_of`, computed if None. Raises FrictoolError if a
    plant's parameters are out of range, or if plants must be drawn but no parameter has a range.
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
        known = parameters or parameters_of(model)
        for name, values in _drawn(model, scenario, owner, known).items():
            variants.append(_variant(name, f"{owner}, plant {name}", model, values))
    return variants


def nominal_variant(model: Model, owner: str = "model") -> AxisVariant:
    """Return the nominal plant; raise FrictoolError if a parameter is out of range."""
    return _variant("", owner, model, {})


def nominal_levels(model: Model) -> dict[str, float]:
    """Return nominal inertia, viscous friction, Coulomb friction and drive constant [SI] by name.

    The nominal value of a friction is the middle of the interval of its level. This level is a mean
    over both directions (adapters/friction_levels.py).
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

    The parameters are the parameters of `nominal_levels`, the breakaway in positive direction, the
    offset, and the backlash if bench.yaml states a backlash. The range of a parameter contains the
    model's interval and the range in bench.yaml.

    The first rule that applies gives the breakaway:

    1. Without Coulomb friction, it is constant.
    2. With presliding, its ratio to the Coulomb friction is constant.
    3. If `breakaway_interval` returns an interval, this interval is its range.
    4. Its ratio to the Coulomb friction has the range `breakaway_ratio`.
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
    offset = model.parameters.offset
    backlash = bench.mechanics.backlash
    parameters["breakaway"] = _breakaway(model, parameters["coulomb"], effort)
    total = valid_total(model)
    if total is not None:  # the loads over the position have their nominal values
        low, high = offset.value - total.error.value, offset.value + total.error.value
        low, high = max(low, offset.interval[0]), min(high, offset.interval[1])
        offset = structs.replace(offset, low=low, high=high)
    ends = hull(offset) if bench.mechanics.offset is None else hull(offset, bench.mechanics.offset)
    parameters["offset"] = VariedParameter(*ends, offset.value, effort, LABELS["offset"])
    if backlash is not None:
        parameters["backlash"] = VariedParameter(
            *backlash.interval, backlash.value, position, LABELS["backlash"]
        )
    return parameters


def breakaway_at(
    parameters: Mapping[str, VariedParameter], coulomb: Vector, parts: Vector
) -> Vector | None:
    """Return breakaways (n,), each from the range that is possible with a Coulomb friction.

    - coulomb (n,): Coulomb frictions [N m | N]
    - parameters: result of `parameters_of`
    - parts (n,): position of each breakaway in its range, 0 (low) to 1 (high)

    Return None if the breakaway has no range.
    """
    one = parameters["breakaway"]
    if one.least is None or one.low == one.high:
        return None
    return drawn_above((one.low, one.high), one.ratio, one.least[1] * coulomb, parts)


def _breakaway(model: Model, coulomb: VariedParameter, unit: str) -> VariedParameter:
    value, label = model.parameters.breakaway.value, LABELS["breakaway"]
    # the mean Coulomb friction differs from the model's parameter if the friction depends on
    # position or direction
    level = coulomb.nominal
    if level <= 0.0:
        return VariedParameter(value, value, value, unit, label)
    limit = least_breakaway(model)
    least = ("coulomb", limit / level)
    if model.presliding is not None or model.parameters.coulomb.value <= 0.0:
        return VariedParameter(value, value, value, unit, label, least)
    known = breakaway_interval(model)
    if known is not None:
        high = max(known[1], least[1] * coulomb.high)
        return VariedParameter(known[0], high, value, unit, label, least)
    # ratio to the smallest breakaway
    low, high = (
        max(1.0, ratio * model.parameters.coulomb.value / limit) for ratio in breakaway_ratio(model)
    )
    if low == high:
        return VariedParameter(value, value, value, unit, label, least)
    ends = (low * least[1] * coulomb.low, high * least[1] * coulomb.high)
    return VariedParameter(*ends, value, unit, label, least, (low, high))


def _drawn(
    model: Model,
    scenario: Scenario,
    owner: str,
    parameters: Mapping[str, VariedParameter],
) -> dict[str, dict[str, float]]:
    assert scenario.plants is not None
    plants, seed = scenario.plants, scenario.seed
    box = ranges(model)
    lows, highs = (np.array([box[name][side] for name in PARAMETERS]) for side in (0, 1))
    drawn = lows + _parts(seed, PLANTS_STREAM, (plants, len(PARAMETERS))) * (highs - lows)
    breakaway = breakaway_at(
        parameters, drawn[:, COULOMB], _parts(seed, BREAKAWAY_STREAM, (plants,))
    )
    if breakaway is None and np.all(lows == highs):
        raise FrictoolError(
            f"{owner}: variants: random needs ranges, but the bench has none; give low and "
            "high in bench.mechanics"
        )
    names: tuple[str, ...] = PARAMETERS
    if breakaway is not None:
        names, drawn = (*PARAMETERS, "breakaway"), np.column_stack([drawn, breakaway])
    width = len(str(plants))
    return {
        f"p{index:0{width}d}": dict(zip(names, map(float, row), strict=True))
        for index, row in enumerate(drawn, start=1)
    }


def _parts(seed: int, stream: int, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return np.random.Generator(np.random.PCG64([seed, stream])).random(shape)


def _variant(name: str, owner: str, model: Model, values: dict[str, float]) -> AxisVariant:
    try:
        axis = axis_of(model, **values)
        return AxisVariant(name, axis, values, dynamic_law_of(model, axis))
    except ValueError as error:
        raise FrictoolError(f"{owner}: {error}") from None
