"""Mechanisms drawn at random: every quantity of the document that has `low` and `high` is drawn
between them, uniformly and on its own.

Mechanism number i of a seed is the same however many there are. A breakaway lies nowhere below its
Coulomb friction: it is drawn from what of its range is above, and one without a range goes with the
Coulomb friction, of which it is a multiple.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from frictool.documents.mechanism import Mechanism
from frictool.documents.reading import DocumentReader, compose
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError, FrictoolError
from frictool.logs.log import MAIN_TOPIC, MECHANISM_TOPIC
from frictool.plant.mechanism.assembly import AssembledMechanism, assemble
from frictool.plant.mechanism.element_error import ElementError
from frictool.simulate.axis_variants import PLANTS_STREAM
from frictool.simulate.given_plant import GIVEN, given_values
from frictool.simulate.mechanism_quantities import quantities_of, ranges, with_quantities
from frictool.simulate.simulated_plant import VariedParameter

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class MechanismVariant:
    """One mechanism, `name` empty for the nominal one; values: what was drawn, by its key, in SI,
    and the unit of each."""

    name: str
    document: Mechanism
    assembled: AssembledMechanism
    values: dict[str, float] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    @property
    def topic(self) -> str:
        """Of the controlled axis: `/axis`, or `/axis/NAME`."""
        return f"{MAIN_TOPIC}/{self.name}" if self.name else MAIN_TOPIC

    @property
    def whole_topic(self) -> str:
        """Of all blocks: `/mechanism`, or `/mechanism/NAME`."""
        return f"{MECHANISM_TOPIC}/{self.name}" if self.name else MECHANISM_TOPIC

    def described(self) -> str:
        """Its values with their units."""
        return ", ".join(
            f"{key} {value:.6g} {self.units[key]}" for key, value in self.values.items()
        )


def mechanism_variants(
    document: Mechanism, assembled: AssembledMechanism, scenario: Scenario, owner: str
) -> list[MechanismVariant]:
    """The nominal mechanism, and `plants` drawn ones where the scenario asks for them; or the one
    that it gives.

    `owner` is what messages call the document. Raises FrictoolError where it has no range to draw
    from, or a mechanism cannot be put together.
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
    found = [MechanismVariant("", document, assembled)]
    if scenario.variants != "random":
        return found
    assert scenario.plants is not None
    every = ranges(document)
    ranged = {key: one for key, one in every.items() if one.low < one.high}
    if not ranged:
        raise FrictoolError(
            f"{owner}: variants: random draws from ranges, and no quantity has one; give low and high beside a value"
        )
    parts = np.random.Generator(np.random.PCG64([scenario.seed, PLANTS_STREAM])).random(
        (scenario.plants, len(ranged))
    )
    width = len(str(scenario.plants))
    for index, row in enumerate(_values(every, ranged, parts), start=1):
        name, values = f"p{index:0{width}d}", dict(zip(ranged, map(float, row), strict=True))
        found.append(
            _variant(
                document,
                name,
                values,
                f"{owner}, plant {name}: ",
                "narrow the ranges that it is drawn from",
            )
        )
    return found


def _values(
    every: Mapping[str, VariedParameter], ranged: Mapping[str, VariedParameter], parts: Vector
) -> Vector:
    """Values (n, d) at parts (n, d) of the ranges, of each range what lies above the value that it
    may not fall below."""
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
        low = np.maximum(lows[index], factor * below)
        drawn[:, index] = low + parts[:, index] * (highs[index] - low)
    return drawn


def _variant(
    document: Mechanism, name: str, values: dict[str, float], owner: str, remedy: str
) -> MechanismVariant:
    """The mechanism with these values. Raises FrictoolError where it cannot be put together."""
    try:
        made = with_quantities(document, values)
    except ValueError as error:  # two values that do not go together
        raise FrictoolError(f"{owner}{error}; {remedy}") from None
    if any(value <= 0.0 for value in values.values()):
        _check_signs(made, owner, remedy)
    units = {key: one.unit for key, one in quantities_of(document) if key in values}
    try:
        return MechanismVariant(name, made, assemble(made), values, units)
    except ElementError as wrong:
        raise FrictoolError(f"{owner}{wrong.key}: {wrong}; {remedy}") from None


def _check_signs(made: Mechanism, owner: str, remedy: str) -> None:
    """Raises FrictoolError where a value is below what its key allows, as when the document is
    read."""
    try:
        DocumentReader(Path()).read(compose(to_yaml(made), Path()), Mechanism, "")
    except DocumentError as error:
        raise FrictoolError(f"{owner}{str(error).partition(': ')[2]}; {remedy}") from None
