"""Parameters of friction laws with their units and bounds, and those that several laws share.

All values are in SI. Two units are written "linear | rotary": friction is a force on a linear axis
and a torque on a rotary one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Axis = Literal["linear", "rotary"]


@dataclass(frozen=True)
class LawParameter:
    """Name, units and bounds of one parameter.

    `exclusive`: the minimum itself is not allowed. `at_least`: name of another parameter that is a
    lower bound of this one.
    """

    name: str
    unit_linear: str
    unit_rotary: str
    minimum: float = 0.0
    maximum: float = math.inf
    exclusive: bool = False
    default: float | None = None
    at_least: str | None = None

    def unit(self, axis: Axis) -> str:
        """Return the SI unit for this kind of axis; empty if the parameter has no unit."""
        return self.unit_linear if axis == "linear" else self.unit_rotary

    def checked(self, value: float, axis: Axis) -> float:
        """Return the value; raise ValueError with the allowed range if it is outside."""
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
POSITIVE_COULOMB = LawParameter("coulomb", "N", "N m", exclusive=True)  # of laws that divide by it
STIFFNESS = LawParameter(
    "stiffness", "N/m", "N m/rad", exclusive=True
)  # sigma_0 of the dynamic laws
DAMPING = LawParameter("damping", "N s/m", "N m s/rad")  # sigma_1
PRESLIDING_LIMIT = LawParameter("presliding_limit", "m", "rad", exclusive=True)  # z_max

# parameters of Stribeck's curve, in the order of friction/stribeck.py
STRIBECK = (COULOMB, BREAKAWAY, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS)
POSITIVE_STRIBECK = (POSITIVE_COULOMB, *STRIBECK[1:])
