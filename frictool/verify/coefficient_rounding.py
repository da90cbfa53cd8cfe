"""Rounding of a controller's coefficients to a number format of the target hardware."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np

from frictool.control.coefficient_words import BITS, round_coefficient
from frictool.documents.controller import LinearController, Number, StateSpace

Rows = tuple[tuple[float, ...], ...]
CoefficientRounder = Callable[[float], float]


def coefficient_rounder(number: Number) -> CoefficientRounder:
    """Return the function that rounds one coefficient to a number format.

    The format is double, float, or a fixed-point word. In fixed point, each coefficient has a
    separate number of fractional bits (control/fixed_point.py).
    """
    if number == "double":
        return float
    if number == "float":
        return lambda value: float(np.float32(value))
    bits = BITS[number]
    return lambda value: round_coefficient(value, bits)


def rounded_linear(linear: LinearController, number: Number) -> LinearController:
    """Return the linear controller with matrices, sections and anti-windup gains rounded.

    number: number format. The continuous-time form is unchanged, because it does not run on the
    target hardware.
    """
    hold = coefficient_rounder(number)

    def rows(matrix: Rows) -> Rows:
        return tuple(tuple(hold(value) for value in row) for row in matrix)

    space = linear.discrete
    gains, sections_gains = rows((linear.anti_windup, linear.sos_anti_windup))
    return msgspec.structs.replace(
        linear,
        discrete=StateSpace(rows(space.a), rows(space.b), rows(space.c), rows(space.d)),
        sos=rows(linear.sos),
        anti_windup=gains,
        sos_anti_windup=sections_gains,
    )
