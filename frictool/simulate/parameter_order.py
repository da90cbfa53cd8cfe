"""Ranges of parameters whose lower limit is another parameter: check, and draws.

An example is the breakaway friction, which must be at least the Coulomb friction. The check passes
if the highest breakaway friction is at least the highest Coulomb friction, or if the ratio of
breakaway to Coulomb friction is constant or drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from frictool.documents.quantity import Quantity, Span, factor_between
from frictool.simulate.document_agreement import DocumentNames, refuse
from frictool.simulate.simulated_plant import VariedParameter
from frictool.typing import Vector

ROUNDING = 1e-9  # relative rounding of a value that a file states in another unit


class ParameterEnds(NamedTuple):
    """Range [SI] of a parameter over the simulated plants, and the key that states this range."""

    low: float
    high: float
    document: str
    key: str


def check_least(
    ranges: Mapping[str, VariedParameter],
    spans: Mapping[str, Span],
    provided: Mapping[str, Quantity],
    names: DocumentNames,
    drawn: bool,
) -> None:
    """Raise DocumentError if a parameter is below its lower limit, which is another parameter.

    - ranges: parameters of the plant by name
    - drawn: True if plants are drawn from ranges
    - spans: ranges in the scenario's key `spread`, used if `drawn` is True
    - provided: values in the scenario's key `given`; if `drawn` is True, only parameters without a
      range use these values
    """
    for name, parameter in ranges.items():
        if parameter.least is None:
            continue
        other, factor = parameter.least
        ends, below = (
            _ends(one, ranges[one], spans, provided, names, drawn) for one in (name, other)
        )
        if (
            (ends.low == ends.high == parameter.nominal or parameter.ratio is not None)
            and ends.document == names.model
        ) or ends.high >= factor * below.high * (1.0 - ROUNDING):
            continue  # the ratio is constant or drawn, or part of the range is above the limit
        label = ranges[other].label
        unit = parameter.unit
        most = f"{factor * below.high:g} {unit}"
        if ends.document == names.model and below.document != names.model:
            problem = f"found up to {most}, above {parameter.label} of {_shown(ends)} {unit}"
            refuse(
                below.document,
                below.key,
                f"{problem}; allowed: at most the {parameter.label}; lower this value, or write a "
                f"range of {parameter.label} too",
            )
        without = "without a range" if ends.document == names.model else "if left out"
        problem = (
            f"found {_shown(ends)} {unit}, below {label} of "
            f"{'up to ' if below.low < below.high else ''}{most}"
        )
        refuse(
            ends.document,
            ends.key,
            f"{problem}; allowed: at least the {label}; {without}, {parameter.label} keeps its "
            f"ratio to {label}",
        )


def drawn_above(
    ends: tuple[float, float], ratio: tuple[float, float] | None, limits: Vector, parts: Vector
) -> Vector:
    """Return the drawn values (n,) of a parameter with a lower limit, in the unit of `ends`.

    - ends: range (low, high) of the parameter
    - ratio: range of the parameter divided by its lower limit; None to draw from `ends`
    - limits (n,): lower limit in each draw
    - parts (n,): position of each value in its range, 0 (low) to 1 (high)
    """
    if ratio is not None:
        return np.asarray(limits * (ratio[0] + parts * (ratio[1] - ratio[0])))
    low = np.maximum(ends[0], limits)
    return np.asarray(low + parts * np.maximum(0.0, ends[1] - low))


def _ends(
    name: str,
    parameter: VariedParameter,
    spans: Mapping[str, Span],
    provided: Mapping[str, Quantity],
    names: DocumentNames,
    drawn: bool,
) -> ParameterEnds:
    if drawn and name in spans:
        scale = factor_between(spans[name].unit, parameter.unit)
        return ParameterEnds(
            scale * spans[name].low,
            scale * spans[name].high,
            names.scenario,
            f"spread.parameters.{name}",
        )
    if name in provided and not (drawn and parameter.low < parameter.high):
        value = factor_between(provided[name].unit, parameter.unit) * provided[name].value
        return ParameterEnds(value, value, names.scenario, f"given.{name}")
    return (
        ParameterEnds(parameter.low, parameter.high, names.model, name)
        if drawn
        else ParameterEnds(parameter.nominal, parameter.nominal, names.model, name)
    )


def _shown(ends: ParameterEnds) -> str:
    return f"{ends.low:g}" if ends.low == ends.high else f"{ends.low:g} to {ends.high:g}"
