"""Presliding (thesis 3.7.4): compliance, hysteresis and loop closure of the contact.

The path of compare/input_protocol.py contains an inner loop from 0.4 z_max to -0.2 z_max
and back, and outer loops between -0.7 and 0.7 z_max. z_max is the largest presliding displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.typing import Vector

INNER_START, INNER_END = 3, 5  # turning points at the start and the end of the inner loop
OUTER_START, OUTER_END = 7, 9  # turning points at the start and the end of the last outer loop
AREA_NEEDED = 0.05  # least `area` of a law with hysteresis
CLOSURE_ALLOWED = 0.02  # limit of `closure` for closed loops


@dataclass(frozen=True)
class PreslidingResult:
    """Measures of presliding.

    - compliance: True if the contact yields to a force below breakaway and springs back
    - closure: change of the friction from the start to the end of the inner loop, divided by the
      breakaway; None without compliance
    - area: area of the last outer loop, divided by the breakaway times the largest presliding
      displacement; None without compliance
    """

    compliance: bool
    closure: float | None
    area: float | None

    @property
    def verdict(self) -> str:
        """Return the symbol of presliding.

        `+`: compliance, hysteresis and closed loops; `±`: compliance, but no hysteresis or no
        closed loops; `-`: no compliance.
        """
        if not self.compliance or self.closure is None or self.area is None:
            return "-"
        return "+" if self.area > AREA_NEEDED and self.closure < CLOSURE_ALLOWED else "±"


def measure(
    position: Vector, friction: Vector, turning: Vector, breakaway: float, presliding: float
) -> PreslidingResult:
    """Return the measures from the friction (n,) along prescribed positions (n,).

    - turning: indices of the turning points, (11,)
    - breakaway: breakaway [N | N m]
    - presliding: largest presliding displacement [m | rad]
    """
    at = turning.astype(int)
    closure = abs(float(friction[at[INNER_END]] - friction[at[INNER_START]])) / breakaway
    loop = slice(at[OUTER_START], at[OUTER_END] + 1)
    area = abs(float(np.trapezoid(friction[loop], position[loop]))) / (breakaway * presliding)
    return PreslidingResult(True, closure, area)


RIGID = PreslidingResult(False, None, None)
