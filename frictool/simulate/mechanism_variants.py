"""Mechanisms drawn at random: every quantity of the document that has `low` and `high` is drawn between them, uniformly and on its own.

Mechanism number i of a seed is the same however many there are. A breakaway that is drawn below its Coulomb friction counts as equal to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from frictool.documents.mechanism import FrictionOf, Mechanism
from frictool.documents.quantity import Quantity
from frictool.documents.reading import Reader, compose
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError, FrictoolError
from frictool.friction.table import LAWS
from frictool.logs.log import MAIN_TOPIC, MECHANISM_TOPIC
from frictool.plant.mechanism.assembly import Assembled, assemble
from frictool.plant.mechanism.wrong import WrongElement
from frictool.simulate.given import GIVEN, given_values
from frictool.simulate.plant import Range
from frictool.simulate.variants import PLANTS_STREAM


@dataclass(frozen=True)
class MechanismVariant:
    """One mechanism, `name` empty for the nominal one; values: what was drawn, by its key, in SI, and the unit of each."""

    name: str
    document: Mechanism
    assembled: Assembled
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
        return ", ".join(f"{key} {value:.6g} {self.units[key]}" for key, value in self.values.items())


def mechanism_variants(document: Mechanism, assembled: Assembled, scenario: Scenario, owner: str) -> list[MechanismVariant]:
    """The nominal mechanism, and `plants` drawn ones where the scenario asks for them; or the one that it gives.

    `owner` is what messages call the document. Raises FrictoolError where it has no range to draw from, or a mechanism cannot be put
    together.
    """
    if scenario.variants == GIVEN:
        return [_variant(document, GIVEN, given_values(scenario, ranges(document)), f"{owner} as given: ", "give another")]
    found = [MechanismVariant("", document, assembled)]
    if scenario.variants != "random":
        return found
    assert scenario.plants is not None
    ranged = {key: one for key, one in ranges(document).items() if one.low < one.high}
    if not ranged:
        raise FrictoolError(f"{owner}: variants: random draws from ranges, and no quantity has one; give low and high beside a value")
    lows, highs = np.array([one.low for one in ranged.values()]), np.array([one.high for one in ranged.values()])
    parts = np.random.Generator(np.random.PCG64([scenario.seed, PLANTS_STREAM])).random((scenario.plants, len(ranged)))
    width = len(str(scenario.plants))
    for index, row in enumerate(lows + parts * (highs - lows), start=1):
        name, values = f"p{index:0{width}d}", dict(zip(ranged, map(float, row), strict=True))
        found.append(_variant(document, name, values, f"{owner}, plant {name}: ", "narrow the ranges that it is drawn from"))
    return found


def ranges(document: Mechanism) -> dict[str, Range]:
    """Of every quantity, by its key, as simulate/plant.py `Plant.ranges`."""
    return {key: Range(*one.interval, one.value, one.unit, key) for key, one in _quantities(document, "")}


def _variant(document: Mechanism, name: str, values: dict[str, float], owner: str, remedy: str) -> MechanismVariant:
    """The mechanism with these values. Raises FrictoolError where it cannot be put together."""
    made = changed(document, values)
    if any(value <= 0.0 for value in values.values()):
        _check_signs(made, owner, remedy)
    units = {key: one.unit for key, one in _quantities(document, "") if key in values}
    try:
        return MechanismVariant(name, made, assemble(made), values, units)
    except WrongElement as wrong:
        raise FrictoolError(f"{owner}{wrong.key}: {wrong}; {remedy}") from None


def _check_signs(made: Mechanism, owner: str, remedy: str) -> None:
    """Raises FrictoolError where a value is below what its key allows, as when the document is read."""
    try:
        Reader(Path()).read(compose(to_yaml(made), Path()), Mechanism, "")
    except DocumentError as error:
        raise FrictoolError(f"{owner}{str(error).partition(': ')[2]}; {remedy}") from None


def changed(document: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The document with other values, by their keys (`blocks.rotor.inertia`), in the units that it has."""
    made: Mechanism = _changed(document, values, "")
    return made


def _quantities(one: Any, key: str) -> Iterator[tuple[str, Quantity]]:
    """Every quantity below `one`, with its key, in the document's order."""
    if isinstance(one, Quantity):
        yield key, one
        return
    for name, below in _parts(one):
        yield from _quantities(below, f"{key}.{name}" if key else name)


def _parts(one: Any) -> list[tuple[str, Any]]:
    if isinstance(one, msgspec.Struct):
        return [(name, getattr(one, name)) for name in one.__struct_fields__]
    return list(one.items()) if isinstance(one, dict) else []


def _changed(one: Any, values: Mapping[str, float], key: str) -> Any:
    if isinstance(one, Quantity):
        return Quantity(value=values[key], unit=one.unit) if key in values else one
    below = {name: _changed(part, values, f"{key}.{name}" if key else name) for name, part in _parts(one)}
    if isinstance(one, dict):
        return below
    if not isinstance(one, msgspec.Struct):
        return one
    made = msgspec.structs.replace(one, **below)
    return _ordered(made) if isinstance(made, FrictionOf) else made


def _ordered(friction: FrictionOf) -> FrictionOf:
    """With each parameter at least what its law says it may not fall below."""
    law = LAWS.get(friction.law)
    if law is None:
        return friction
    parameters = dict(friction.parameters)
    for parameter in law.parameters:
        own, least = parameters.get(parameter.name), parameters.get(parameter.at_least or "")
        if own is not None and least is not None and own.unit == least.unit and own.value < least.value:
            parameters[parameter.name] = Quantity(value=least.value, unit=own.unit)
    return msgspec.structs.replace(friction, parameters=parameters)
