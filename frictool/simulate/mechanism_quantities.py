"""The quantities of a mechanism by their keys, `blocks.rotor.inertia`: where each may lie, and the
mechanism with other values of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from frictool.documents.mechanism import FrictionOf, Mechanism
from frictool.documents.quantity import Quantity, factor_between
from frictool.friction.law_registry import LAWS
from frictool.simulate.simulated_plant import VariedParameter


def quantities_of(document: Mechanism) -> Iterator[tuple[str, Quantity]]:
    """Every quantity, with its key, in the document's order."""
    yield from _walk(document, "")


def ranges(document: Mechanism) -> dict[str, VariedParameter]:
    """Of every quantity, by its key, as simulate/simulated_plant.py `Plant.ranges`."""
    least = dict(_leasts(document, ""))
    return {
        key: VariedParameter(*one.interval, one.value, one.unit, key, least.get(key))
        for key, one in quantities_of(document)
    }


def with_quantities(document: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The document with other values, by their keys (`blocks.rotor.inertia`), in the units that it
    has."""
    made: Mechanism = _changed(document, values, "")
    return made


def _walk(one: Any, key: str) -> Iterator[tuple[str, Quantity]]:
    """Every quantity below `one`, with its key, in the document's order."""
    if isinstance(one, Quantity):
        yield key, one
        return
    for name, below in _parts(one):
        yield from _walk(below, f"{key}.{name}" if key else name)


def _leasts(one: Any, key: str) -> Iterator[tuple[str, tuple[str, float]]]:
    """Of every parameter of a friction law that may not fall below another: its key, the other's,
    and the factor between their units."""
    if isinstance(one, FrictionOf):
        for name, other in _pairs(one):
            factor = factor_between(one.parameters[other].unit, one.parameters[name].unit)
            yield f"{key}.parameters.{name}", (f"{key}.parameters.{other}", factor)
        return
    for name, below in _parts(one):
        yield from _leasts(below, f"{key}.{name}" if key else name)


def _pairs(friction: FrictionOf) -> list[tuple[str, str]]:
    """The parameters that are there and may not fall below another one, and that one."""
    law, there = LAWS.get(friction.law), friction.parameters
    named = (
        [(parameter.name, parameter.at_least or "") for parameter in law.parameters]
        if law is not None
        else []
    )
    return [(name, other) for name, other in named if name in there and other in there]


def _parts(one: Any) -> list[tuple[str, Any]]:
    if isinstance(one, msgspec.Struct):
        return [(name, getattr(one, name)) for name in one.__struct_fields__]
    return list(one.items()) if isinstance(one, dict) else []


def _changed(one: Any, values: Mapping[str, float], key: str) -> Any:
    if isinstance(one, Quantity):
        return Quantity(value=values[key], unit=one.unit) if key in values else one
    below = {
        name: _changed(part, values, f"{key}.{name}" if key else name) for name, part in _parts(one)
    }
    if isinstance(one, dict):
        return below
    if not isinstance(one, msgspec.Struct):
        return one
    made = msgspec.structs.replace(one, **below)
    if isinstance(one, FrictionOf) and isinstance(made, FrictionOf):
        return _ordered(
            one, made, {name for name in one.parameters if f"{key}.parameters.{name}" in values}
        )
    return made


def _ordered(document: FrictionOf, made: FrictionOf, given: set[str]) -> FrictionOf:
    """`made` of the document's, with each parameter that is not given in the document's proportion
    to the one that it may not fall below, and none below that by a rounding.
    """
    parameters = dict(made.parameters)
    for name, other in _pairs(made):
        own, least, before = parameters[name], parameters[other], document.parameters[other].value
        if name not in given and other in given and before > 0.0:
            own = parameters[name] = Quantity(value=own.value / before * least.value, unit=own.unit)
        if own.value < least.value * factor_between(least.unit, own.unit):
            parameters[name] = Quantity(value=least.value, unit=least.unit)
    return msgspec.structs.replace(made, parameters=parameters)
