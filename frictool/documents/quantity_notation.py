"""Notation of a quantity in documents and error messages, such as `{value: 10, unit: A}`."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Literal

from frictool.documents.quantity import (
    CHOICES,
    Axis,
    chosen_dimension,
    drive_dimension,
    si_unit,
    unit_scale,
)

UNKNOWN = ".."
NUMBER_WITH_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def written_quantity(text: str) -> tuple[str, str] | None:
    """Split a quantity that is written as one text into the number and the unit.

    Return None if the text does not begin with a number.

    >>> written_quantity("1.5e-2 N m"), written_quantity("10"), written_quantity("many")
    (('1.5e-2', 'N m'), ('10', ''), None)
    """
    match = NUMBER_WITH_UNIT.fullmatch(text)
    return None if match is None else (match[1], match[2])


def axis_dimension(dimension: str, drive: Literal["current", "voltage"]) -> str:
    """Return the dimension with `drive` replaced by the dimension of a current or a voltage.

    "effort per drive" becomes the effort per ampere or volt; other dimensions are unchanged.
    """
    if dimension in ("drive", "effort per drive"):
        return drive_dimension(drive, constant=dimension != "drive")
    return dimension


def quantity_form(required: Sequence[str], values: Mapping[str, str]) -> str:
    """Return the notation of a quantity, with `..` for each required key without a value.

    >>> quantity_form(["value", "unit"], {"unit": "A"})
    '{value: .., unit: A}'
    """
    return (
        "{"
        + ", ".join(
            f"{name}: {values.get(name, '[..]' if name == 'values' else UNKNOWN)}"
            for name in required
        )
        + "}"
    )


def example_unit(
    dimension: str, axis: Axis, drive: Literal["current", "voltage"], written: str = ""
) -> str:
    """Return a unit of the dimension for a message: `written` if it fits, else an SI unit.

    For the dimension `any`, return `written`, or `..` if `written` is empty.
    """
    if dimension == "any":
        return written or UNKNOWN
    dimension = axis_dimension(dimension, drive)
    try:
        if written and dimension in CHOICES:
            chosen_dimension(written, dimension)
        elif written:
            unit_scale(written, dimension, axis)
    except ValueError:
        written = ""
    if written:
        return written
    name, kind = CHOICES[dimension][0] if dimension in CHOICES else (dimension, axis)
    return si_unit(name, kind)
