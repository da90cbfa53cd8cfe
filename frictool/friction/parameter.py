"""Parameters of friction laws: name, units and bounds; those that several laws share.

SI throughout, linear | rotary. What opposes the motion is a force on a linear axis and a torque on
a rotary one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Axis = Literal["linear", "rotary"]


@dataclass(frozen=True)
class LawParameter:
    """One parameter. `exclusive`: the minimum itself is refused. `at_least`: another parameter that
    this one may not fall below."""

    name: str
    unit_linear: str
    unit_rotary: str
    minimum: float = 0.0
    maximum: float = math.inf
    exclusive: bool = False
    default: float | None = None
    at_least: str | None = None

    def unit(self, axis: Axis) -> str:
        """The SI unit for this kind of axis; empty where it has none."""
        return self.unit_linear if axis == "linear" else self.unit_rotary

    def checked(self, value: float, axis: Axis) -> float:
        """The value. Raises ValueError saying what was found and what is allowed."""
        low = value > self.minimum if self.exclusive else value >= self.minimum
        if math.isfinite(value) and low and value <= self.maximum:
            return float(value)
        unit = f" {self.unit(axis)}".rstrip()
        upper = f" and <= {self.maximum:g}{unit}" if math.isfinite(self.maximum) else ""
        lower = f"{'>' if self.exclusive else '>='} {self.minimum:g}{unit}"
        raise ValueError(f"{self.name} is {value:g}{unit}; allowed: a finite number {lower}{upper}")


COULOMB = LawParameter("coulomb", "N", "N m")  # F_c
BREAKAWAY = LawParameter("breakaway", "N", "N m", at_least="coulomb")  # F_s
VISCOUS = LawParameter("viscous", "N s/m", "N m s/rad")  # sigma_v; sigma_0 in (2.31)-(2.36)
STRIBECK_VELOCITY = LawParameter("stribeck_velocity", "m/s", "rad/s", exclusive=True)  # v_s
STRIBECK_EXPONENT = LawParameter(
    "stribeck_exponent", "", "", exclusive=True, maximum=100.0, default=2.0
)  # delta_s
POSITIVE_COULOMB = LawParameter(
    "coulomb", "N", "N m", exclusive=True
)  # where a state is measured against it
STIFFNESS = LawParameter(
    "stiffness", "N/m", "N m/rad", exclusive=True
)  # sigma_0 of the dynamic laws
DAMPING = LawParameter("damping", "N s/m", "N m s/rad")  # sigma_1
PRESLIDING_LIMIT = LawParameter("presliding_limit", "m", "rad", exclusive=True)  # z_max

# the curve of Stribeck, in the order of friction/stribeck.py
STRIBECK = (COULOMB, BREAKAWAY, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS)
POSITIVE_STRIBECK = (POSITIVE_COULOMB, *STRIBECK[1:])
