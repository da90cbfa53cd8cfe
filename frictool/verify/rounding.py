"""The linear controller with its coefficients as a number format of the target holds them, in every form that may run."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from frictool.documents.controller import LinearController, StateSpace

Number = Literal["double", "float"]
Rows = tuple[tuple[float, ...], ...]


def rounded_linear(linear: LinearController, number: Number) -> LinearController:
    """Matrices, sections and anti-windup gains rounded; the continuous form does not run and stays."""
    if number == "double":
        return linear
    space, replace = linear.discrete, msgspec.structs.replace
    a, b, c, d = (_single(rows) for rows in (space.a, space.b, space.c, space.d))
    gains, sections_gains = _single((linear.anti_windup, linear.sos_anti_windup))
    return replace(
        linear,
        discrete=StateSpace(a, b, c, d),
        sos=_single(linear.sos),
        anti_windup=gains,
        sos_anti_windup=sections_gains,
    )


def _single(rows: Rows) -> Rows:
    return tuple(tuple(float(np.float32(value)) for value in row) for row in rows)
