"""Random mechanisms: every quantity with `low` and `high` is drawn uniformly and independently.

If more mechanisms are drawn with the same seed, the first mechanisms stay the same. A breakaway
friction is drawn from the part of its range above the drawn Coulomb friction. If the breakaway
friction has no range, its ratio to the Coulomb friction stays constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.document_reader import DocumentReader
from frictool.documents.document_text import compose
from frictool.documents.mechanism import Mechanism
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError, FrictoolError
from frictool.logs.log import MAIN_TOPIC, MECHANISM_TOPIC
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.element_error import ElementError
from frictool.simulate.axis_variants import PLANTS_STREAM
from frictool.simulate.mechanism_parameters import quantities_of, ranges, with_quantities
from frictool.simulate.parameter_order import drawn_above
from frictool.simulate.scenario_plant_values import GIVEN, given_values
from frictool.simulate.simulated_plant import VariedParameter
from frictool.typing import Vector


@dataclass(frozen=True)
class MechanismVariant:
    """Variant of a mechanism, as a document and as arrays.

    - name: name of the variant, empty for the nominal mechanism
    - values: quantities [SI] that are drawn or stated under `given`, by key
    - units: unit of each quantity in `values`, by key
    """

    name: str
    document: Mechanism
    assembled: AssembledMechanism
    values: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    @property
    def topic(self) -> str:
        """Return the topic of the controlled axis, `/axis` or `/axis/NAME`."""
        return f"{MAIN_TOPIC}/{self.name}" if self.name else MAIN_TOPIC

    @property
    def whole_topic(self) -> str:
        """Return the topic of all blocks, `/mechanism` or `/mechanism/NAME`."""
        return f"{MECHANISM_TOPIC}/{self.name}" if self.name else MECHANISM_TOPIC

    def described(self) -> str:
        """Return the values that differ from the nominal mechanism, with their units, as text."""
        return ", ".join(
            f"{key} {value:.6g} {self.units[key]}" for key, value in self.values.items()
        )


def mechanism_variants(
    document: Mechanism, assembled: AssembledMechanism, scenario: Scenario, owner: str
) -> list[MechanismVariant]:
    """Return the mechanisms that the key `variants` of a scenario selects.

    The nominal mechanism comes first; random mechanisms follow. For `variants: given`, the only
    mechanism has the values under `given`. `owner` is the name of the document in messages. Raises
    FrictoolError if mechanisms must be drawn but no quantity has a range, or if a mechanism cannot
    be assembled.
    """
    if scenario.variants == GIVEN:
        return [
            _variant(
                document,
                GIVEN,
                given_values(scenario, ranges(document)),
                f"{owner} as given: ",
                "give another",
            )
        ]
    variants = [MechanismVariant("", document, assembled)]
    if scenario.variants != "random":
        return variants
    assert scenario.plants is not None
    every = ranges(document)
    ranged = {key: one for key, one in every.items() if one.low < one.high}
    if not ranged:
        raise FrictoolError(
            f"{owner}: variants: random needs ranges, but no quantity has one; add low and "
            "high to a value"
        )
    parts = np.random.Generator(np.random.PCG64([scenario.seed, PLANTS_STREAM])).random(
        (scenario.plants, len(ranged))
    )
    width = len(str(scenario.plants))
    for index, row in enumerate(_values(every, ranged, parts), start=1):
        name = f"p{index:0{width}d}"
        values = dict(zip(ranged, map(float, row), strict=True))
        variants.append(
            _variant(
                document,
                name,
                values,
                f"{owner}, plant {name}: ",
                "narrow the ranges of its quantities",
            )
        )
    return variants


def _values(
    every: Mapping[str, VariedParameter], ranged: Mapping[str, VariedParameter], parts: Vector
) -> Vector:
    """Return the values (n, d) of d parameters in n variants.

    parts (n, d): position of each value in the range of the parameter, 0 (low) to 1 (high). If the
    lower limit of a parameter is another parameter, the range begins at the value of the other
    parameter.
    """
    lows, highs = (
        np.array([one.low for one in ranged.values()]),
        np.array([one.high for one in ranged.values()]),
    )
    drawn: Vector = lows + parts * (highs - lows)
    for index, one in enumerate(ranged.values()):
        if one.least is None:
            continue
        other, factor = one.least
        below = drawn[:, list(ranged).index(other)] if other in ranged else every[other].nominal
        limits = np.broadcast_to(factor * below, drawn.shape[:1])
        drawn[:, index] = drawn_above((one.low, one.high), one.ratio, limits, parts[:, index])
    return drawn


def _variant(
    document: Mechanism, name: str, values: dict[str, float], owner: str, remedy: str
) -> MechanismVariant:
    try:
        made = with_quantities(document, values)
    except ValueError as error:
        raise FrictoolError(f"{owner}{error}; {remedy}") from None
    if any(value <= 0.0 for value in values.values()):
        _check_signs(made, owner, remedy)
    units = {key: one.unit for key, one in quantities_of(document) if key in values}
    try:
        return MechanismVariant(name, made, assemble(made), values, units)
    except ElementError as wrong:
        raise FrictoolError(f"{owner}{wrong.key}: {wrong}; {remedy}") from None


def _check_signs(made: Mechanism, owner: str, remedy: str) -> None:
    try:
        DocumentReader(Path()).read(compose(to_yaml(made), Path()), Mechanism, "")
    except DocumentError as error:
        raise FrictoolError(f"{owner}{str(error).partition(': ')[2]}; {remedy}") from None
