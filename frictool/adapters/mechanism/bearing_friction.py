"""Friction of a bearing or slideway: law and parameters of a document as arrays for kernels."""

from __future__ import annotations

import difflib

from frictool.documents.mechanism import FrictionOf
from frictool.documents.quantity import Axis, Quantity, factor_between
from frictool.friction.law import Law
from frictool.friction.law_registry import LAWS, ROWS
from frictool.plant.mechanism.element_error import ElementError
from frictool.typing import Vector


def law_row(law: Law) -> int:
    """Return the index of the law in friction/law_registry.py."""
    return ROWS.index(law)


def pack_law(key: str, friction: FrictionOf, kind: Axis, inertia: float) -> tuple[Law, Vector]:
    """Return the law and the array p of its parameters in SI.

    - `key`: key of the friction element in the document, for errors
    - `kind`: motion of the block, rotary or linear
    - `inertia`: inertia of the block, for laws that need an inertia but have no parameter for it

    Raises ElementError if the law or a parameter is unknown, missing, in a wrong unit or out of
    range.
    """
    law = LAWS.get(friction.law)
    if law is None:
        near = difflib.get_close_matches(friction.law, list(LAWS), n=1, cutoff=0.5)
        hint = f", did you mean {near[0]!r}?" if near else ""
        raise ElementError(
            f"{key}.law", f"found {friction.law!r}{hint}; allowed: {', '.join(LAWS)}"
        )
    values = {
        name: _value(f"{key}.parameters.{name}", law, name, quantity, kind)
        for name, quantity in friction.parameters.items()
    }
    if "inertia" in {parameter.name for parameter in law.parameters}:
        values.setdefault("inertia", inertia)
    try:
        return law, law.pack(values, kind)
    except ValueError as error:
        raise ElementError(f"{key}.parameters", str(error)) from None


def si_parameters(key: str, friction: FrictionOf, kind: Axis) -> dict[str, Quantity]:
    """Return the law parameters of a document, converted to SI, with their intervals.

    Raises ElementError for the reasons that `pack_law` lists.
    """
    law = LAWS[friction.law]
    out = {}
    for name, quantity in friction.parameters.items():
        unit = law.parameters[law.index(name)].unit(kind)
        factor = factor_between(quantity.unit, unit)
        low, high = (
            None if bound is None else bound * factor for bound in (quantity.low, quantity.high)
        )
        out[name] = Quantity(
            _value(f"{key}.parameters.{name}", law, name, quantity, kind), low, high, unit
        )
    return out


def _value(key: str, law: Law, name: str, quantity: Quantity, kind: Axis) -> float:
    try:
        parameter = law.parameters[law.index(name)]
    except ValueError as error:
        raise ElementError(key, str(error)) from None
    try:
        factor = factor_between(quantity.unit, parameter.unit(kind))
    except ValueError as error:
        raise ElementError(f"{key}.unit", f"found {error}") from None
    try:
        for bound in quantity.interval:
            parameter.checked(bound * factor, kind)
        return parameter.checked(quantity.value * factor, kind)
    except ValueError as error:
        raise ElementError(key, str(error)) from None
