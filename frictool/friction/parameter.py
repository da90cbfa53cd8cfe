"""Parameters of friction laws, with unit and bounds; some are shared by several laws.

All values are in SI. Friction is a force on a linear axis and a torque on a rotary one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

Axis = Literal["linear", "rotary"]
Values = Mapping[str, float]  # SI values by the keys of compare/law_simulator.py `law_values`


ROTARY = {"N": "N m", "m": "rad", "kg": "kg m^2"}  # unit on a linear axis -> on a rotary one


@dataclass(frozen=True)
class LawParameter:
    """Name, unit and bounds of one parameter.

    - linear_unit: SI unit on a linear axis; empty if the parameter has none
    - exclusive: True if the value must be above `minimum`, not equal to it
    - at_least: name of another parameter that is a lower bound of this parameter
    - letters: symbol in text and in LaTeX; by default the name
    - simulation_only: True if the parameter belongs to the simulation and is not identified
    - comparison_value: function that computes the parameter from the values of a friction.yaml
      (`frictool compare`) or a model.yaml (`frictool simulate`). If it is None, the parameter has
      the value of the same name, or `default` if the file has no such value
    """

    name: str
    linear_unit: str
    minimum: float = 0.0
    maximum: float = math.inf
    exclusive: bool = False
    default: float | None = None
    at_least: str | None = None
    letters: tuple[str, str] | None = None
    simulation_only: bool = False
    comparison_value: Callable[[Values], float] | None = None

    def unit(self, axis: Axis) -> str:
        """Return the SI unit for this kind of axis; empty if the parameter is dimensionless."""
        if axis == "linear":
            return self.linear_unit
        return re.sub("[A-Za-z]+", lambda unit: ROTARY.get(unit[0], unit[0]), self.linear_unit)

    def checked(self, value: float, axis: Axis) -> float:
        """Return `value`; raise ValueError with the allowed range if it is outside this range."""
        low = value > self.minimum if self.exclusive else value >= self.minimum
        if math.isfinite(value) and low and value <= self.maximum:
            return float(value)
        unit = f" {self.unit(axis)}".rstrip()
        upper = f" and <= {self.maximum:g}{unit}" if math.isfinite(self.maximum) else ""
        lower = f"{'>' if self.exclusive else '>='} {self.minimum:g}{unit}"
        raise ValueError(f"{self.name} is {value:g}{unit}; allowed: a finite number {lower}{upper}")


COULOMB = LawParameter("coulomb", "N", letters=("Fc", "F_c"))
BREAKAWAY = LawParameter("breakaway", "N", at_least="coulomb", letters=("Fs", "F_s"))
# sigma_0 in (2.31)-(2.36)
VISCOUS = LawParameter("viscous", "N s/m", letters=("sigma_v", r"\sigma_v"))
STRIBECK_VELOCITY = LawParameter("stribeck_velocity", "m/s", exclusive=True, letters=("v_s", "v_s"))
STRIBECK_EXPONENT = LawParameter(
    "stribeck_exponent", "", 0.0, 100.0, exclusive=True, default=2.0, letters=("delta", r"\delta")
)
POSITIVE_COULOMB = replace(COULOMB, exclusive=True)  # F_c of laws that divide by F_c
# parameters of the dynamic laws
STIFFNESS = LawParameter("stiffness", "N/m", exclusive=True, letters=("sigma_0", r"\sigma_0"))
DAMPING = LawParameter("damping", "N s/m", letters=("sigma_1", r"\sigma_1"))
PRESLIDING_LIMIT = LawParameter("presliding_limit", "m", exclusive=True)  # z_max

# parameters of Stribeck's curve, in the order of friction/stribeck.py
STRIBECK = (COULOMB, BREAKAWAY, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS)
POSITIVE_STRIBECK = (POSITIVE_COULOMB, *STRIBECK[1:])
