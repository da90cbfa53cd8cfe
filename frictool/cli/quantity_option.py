"""A quantity as an option gives it: a number, with its unit where it is not in SI, `10rad/s` or
`"0.4 m/s"`."""

from __future__ import annotations

import math

import click

from frictool.documents.quantity import Axis, factor_to_si, si_unit
from frictool.documents.quantity_text import written_quantity


def positive_si(option: str, text: str, dimension: str, axis: Axis) -> float:
    """The number in SI. Raises click.UsageError naming the option for what is no number above 0, or
    has a unit of something else."""
    unit = si_unit(dimension, axis)
    written = written_quantity(text)
    if written is None:
        raise click.UsageError(
            f"{option}: found {text!r}; allowed: a number with or without its unit, such as 10 or 10{unit.replace(' ', '')}."
        )
    digits, given = written
    try:
        number = float(digits) * (factor_to_si(given, dimension, axis) if given else 1.0)
    except ValueError as error:
        raise click.UsageError(f"{option}: {error}.") from None
    if not (math.isfinite(number) and number > 0.0):
        raise click.UsageError(f"{option}: found {text!r}; allowed: above 0 {unit}.")
    return number
