"""Quantities as options: a number in SI or with a unit, such as `10rad/s` or `"0.4 m/s"`."""

from __future__ import annotations

import math

import click

from frictool.documents.quantity import Axis, factor_to_si, si_unit
from frictool.documents.quantity_notation import written_quantity


def positive_si(option: str, text: str, dimension: str, axis: Axis) -> float:
    """Return the quantity `text` as a number in SI.

    Raises click.UsageError, with the name of the option, if `text` is not a number above 0, or if
    its unit does not have the dimension `dimension`.
    """
    unit = si_unit(dimension, axis)
    written = written_quantity(text)
    if written is None:
        raise click.UsageError(
            f"{option}: found {text!r}; allowed: a number with or without its unit, "
            f"such as 10 or 10{unit.replace(' ', '')}."
        )
    digits, symbol = written
    try:
        number = float(digits) * (factor_to_si(symbol, dimension, axis) if symbol else 1.0)
    except ValueError as error:
        raise click.UsageError(f"{option}: {error}.") from None
    if not (math.isfinite(number) and number > 0.0):
        raise click.UsageError(f"{option}: found {text!r}; allowed: above 0 {unit}.")
    return number
