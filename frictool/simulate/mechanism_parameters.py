"""Parameters of a mechanism by key, such as `blocks.rotor.inertia`, and their ranges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from frictool.documents.mechanism import FrictionOf, Mechanism
from frictool.documents.quantity import Quantity, factor_between
from frictool.friction.law_registry import LAWS
from frictool.simulate.simulated_plant import VariedParameter


def quantities_of(document: Mechanism) -> Iterator[tuple[str, Quantity]]:
    """Yield (key, quantity) for every quantity of the document, in the order of the file."""
    yield from _walk(document, "")


def ranges(document: Mechanism) -> dict[str, VariedParameter]:
    """Return range and nominal value of every quantity of a mechanism, by key."""
    least = dict(_leasts(document, ""))
    return {
        key: VariedParameter(*one.interval, one.value, one.unit, key, least.get(key))
        for key, one in quantities_of(document)
    }


def with_quantities(document: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """Return a copy of the document with `values` (numbers in the document's units, by key)."""
    made: Mechanism = _changed(document, values, "")
    return made


def _walk(one: Any, key: str) -> Iterator[tuple[str, Quantity]]:
    if isinstance(one, Quantity):
        yield key, one
        return
    for name, below in _parts(one):
        yield from _walk(below, f"{key}.{name}" if key else name)


def _leasts(one: Any, key: str) -> Iterator[tuple[str, tuple[str, float]]]:
    if isinstance(one, FrictionOf):
        for name, other in _pairs(one):
            factor = factor_between(one.parameters[other].unit, one.parameters[name].unit)
            yield f"{key}.parameters.{name}", (f"{key}.parameters.{other}", factor)
        return
    for name, below in _parts(one):
        yield from _leasts(below, f"{key}.{name}" if key else name)


def _pairs(friction: FrictionOf) -> list[tuple[str, str]]:
    law = LAWS.get(friction.law)
    there = friction.parameters
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


def _ordered(document: FrictionOf, made: FrictionOf, provided: set[str]) -> FrictionOf:
    """Return the friction `made`; a parameter below its lower limit is raised to this limit.

    The lower limit of a parameter is another parameter. If `provided` contains the limit but not
    the parameter, the ratio of the parameter to the limit stays as in `document`.
    """
    parameters = dict(made.parameters)
    for name, other in _pairs(made):
        parameter = parameters[name]
        least = parameters[other]
        before = document.parameters[other].value
        if name not in provided and other in provided and before > 0.0:
            parameter = parameters[name] = Quantity(
                value=parameter.value / before * least.value, unit=parameter.unit
            )
        if parameter.value < least.value * factor_between(least.unit, parameter.unit):
            parameters[name] = Quantity(value=least.value, unit=least.unit)
    return msgspec.structs.replace(made, parameters=parameters)
