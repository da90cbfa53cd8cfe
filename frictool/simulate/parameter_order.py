"""Whether a parameter that may not fall below another, a breakaway below its Coulomb friction, can
be at least as large in every plant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from frictool.documents.quantity import Quantity, Span, factor_between
from frictool.simulate.document_agreement import DocumentNames, refuse
from frictool.simulate.simulated_plant import VariedParameter

ROUNDING = 1e-9  # of a value that a file has in another unit


class ParameterEnds(NamedTuple):
    """Between what a parameter lies in the plants that are played [SI], and the document and the
    key that say so."""

    low: float
    high: float
    document: str
    key: str


def check_least(
    ranges: Mapping[str, VariedParameter],
    spans: Mapping[str, Span],
    given: Mapping[str, Quantity],
    names: DocumentNames,
    drawn: bool,
) -> None:
    """Raises DocumentError with the key of a value, or of a range, that ends below what it may not
    fall below.

    spans, given: what the scenario says of parameters in place of their own ranges, in units that
    fit. drawn: whether the ranges are drawn from, or the values that are given played and else
    those of the document.
    """
    for name, own in ranges.items():
        if own.least is None:
            continue
        other, factor = own.least
        ends, below = (_ends(one, ranges[one], spans, given, names, drawn) for one in (name, other))
        if (
            ends.low == ends.high == own.nominal and ends.document == names.model
        ) or ends.high >= factor * below.high * (1.0 - ROUNDING):
            continue  # it goes with the other, or there is always something above
        label, unit = ranges[other].label, own.unit
        most = f"{factor * below.high:g} {unit}"
        if ends.document == names.model and below.document != names.model:
            found = f"found up to {most}, above {own.label}, {_shown(ends)} {unit}"
            refuse(
                below.document,
                below.key,
                f"{found}; allowed: at most that; write a range of {own.label} too",
            )
        without = "without a range" if ends.document == names.model else "left out"
        found = f"found {_shown(ends)} {unit}, below {label} of {'up to ' if below.low < below.high else ''}{most}"
        refuse(
            ends.document,
            ends.key,
            f"{found}; allowed: at least that; {without}, it goes with {label}",
        )


def _ends(
    name: str,
    own: VariedParameter,
    spans: Mapping[str, Span],
    given: Mapping[str, Quantity],
    names: DocumentNames,
    drawn: bool,
) -> ParameterEnds:
    if drawn and name in spans:
        scale = factor_between(spans[name].unit, own.unit)
        return ParameterEnds(
            scale * spans[name].low,
            scale * spans[name].high,
            names.scenario,
            f"spread.parameters.{name}",
        )
    if name in given and not (drawn and own.low < own.high):
        value = factor_between(given[name].unit, own.unit) * given[name].value
        return ParameterEnds(value, value, names.scenario, f"given.{name}")
    return (
        ParameterEnds(own.low, own.high, names.model, name)
        if drawn
        else ParameterEnds(own.nominal, own.nominal, names.model, name)
    )


def _shown(ends: ParameterEnds) -> str:
    return f"{ends.low:g}" if ends.low == ends.high else f"{ends.low:g} to {ends.high:g}"
