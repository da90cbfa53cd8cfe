"""What any law takes on top: its force levels as functions of direction, position and time at rest.

    F_c(x, direction)    = F_c(direction) position factor(x, direction)
    F_s(x, direction, t) = F_s(direction) position factor(x, direction) dwell factor(t), never below F_c

Before it asks a law, a driver writes the levels that hold now into the law's parameter array: the law's kernels stay as they are.
What adds to the force (friction/speed_knee.py) or changes the velocity that the dry part sees (friction/film.py) it composes itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from frictool.friction.dwell import dwell_factor
from frictool.friction.law import Law
from frictool.friction.parameter import Axis
from frictool.friction.position_polynomial import position_factor
from frictool.kernels import kernel

Vector = NDArray[np.float64]
CONSTANT: tuple[float, ...] = (1.0,)

# layout of the packed extension; the coefficients of both polynomials follow
BREAKAWAY_INDEX, FRESH, RISE_TIME, LOW, HIGH, FORWARD_COUNT, COEFFICIENTS = 0, 1, 2, 3, 4, 5, 6


@dataclass(frozen=True)
class Extension:
    """A law's levels over direction, position and dwell; the default changes nothing.

    forward, backward: coefficients of the position factors, lowest power first, over travel = (low, high) [m | rad], as
    `position_polynomial.normalised` gives them. fresh in (0, 1], rise_time [s]: friction/dwell.py.
    """

    backward_values: Mapping[str, float] = field(default_factory=dict)  # parameters that differ in the negative direction
    forward: tuple[float, ...] = CONSTANT
    backward: tuple[float, ...] = CONSTANT
    travel: tuple[float, float] = (0.0, 1.0)
    fresh: float = 1.0
    rise_time: float = 0.0

    def pack(self, law: Law, values: Mapping[str, float], axis: Axis = "linear") -> tuple[Vector, Vector, Vector]:
        """(p forward, p backward, extension array) for `levels`. Raises ValueError, one line, for what is out of range."""
        numbers = np.array([*self.forward, *self.backward, *self.travel])
        if not self.forward or not self.backward or not np.all(np.isfinite(numbers)) or self.travel[0] >= self.travel[1]:
            raise ValueError(f"position factors need finite coefficients and a travel low < high, found {list(self.travel)}")
        if not 0.0 < self.fresh <= 1.0 or not (np.isfinite(self.rise_time) and self.rise_time >= 0.0):
            raise ValueError(f"fresh is {self.fresh:g}, rise_time {self.rise_time:g} s; allowed: fresh in (0, 1], rise_time >= 0")
        names = [parameter.name for parameter in law.parameters]
        if self.rise_time > 0.0 and "breakaway" not in names:
            raise ValueError(f"{law.name} has no breakaway that could rise with the time at rest")
        place = names.index("breakaway") if "breakaway" in names else -1
        head = [place, self.fresh, self.rise_time, *self.travel, len(self.forward)]
        packed = np.array([*head, *self.forward, *self.backward], dtype=np.float64)
        return law.pack(values, axis), law.pack({**values, **self.backward_values}, axis), packed


@kernel
def levels(forward: Vector, backward: Vector, extension: Vector, x: float, direction: float, dwell: float, out: Vector) -> None:
    """Fills out with the law's parameters that hold at x [m | rad], in `direction`, after `dwell` [s] at rest."""
    split = COEFFICIENTS + int(extension[FORWARD_COUNT])
    out[:] = forward if direction > 0.0 else backward
    coefficients = extension[COEFFICIENTS:split] if direction > 0.0 else extension[split:]
    factor = position_factor(coefficients, extension[LOW], extension[HIGH], x)
    out[0] *= factor
    place = int(extension[BREAKAWAY_INDEX])
    if place >= 0:
        rested = out[place] * factor * dwell_factor(dwell, extension[FRESH], extension[RISE_TIME])
        out[place] = max(out[0], rested)
