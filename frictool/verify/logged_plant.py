"""Linear plant of a simulated axis, as stored in the metadata of the log."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass

from frictool.plant.polytope import PlantPoint

# metadata record that maps each topic to its LoggedPlant as JSON
RECORD = "played_plants"
# metadata record that maps each parameter of the simulated model to [low, high] as JSON
INTERVALS = "model_intervals"


@dataclass(frozen=True)
class LoggedPlant:
    """Linear plant of one axis, in SI units.

    - inertia, viscous, coulomb, constant: parameters that a scheduled controller uses
    - slopes: viscous friction coefficients of each direction and speed range
    - constants: efforts per unit of drive

    If the parameters drift during the simulation, `slopes` and `constants` include their extreme
    values.
    """

    inertia: float
    viscous: float
    coulomb: float
    constant: float
    slopes: tuple[float, ...]
    constants: tuple[float, ...]

    @property
    def point(self) -> PlantPoint:
        """Return the plant with the parameters that a scheduled controller uses."""
        return PlantPoint("", self.inertia, self.viscous, self.coulomb, self.constant)

    @property
    def is_possible(self) -> bool:
        """Return True if all numbers are finite, the inertia is positive, and no list is empty."""
        levels = self.inertia, self.viscous, self.coulomb, self.constant
        finite = all(map(math.isfinite, (*levels, *self.slopes, *self.constants)))
        return finite and self.inertia > 0.0 and bool(self.slopes and self.constants)

    def points(self) -> tuple[PlantPoint, ...]:
        """Return all linear plants of the axis: each viscous coefficient with each constant."""
        pairs = itertools.product(self.slopes, self.constants)
        return tuple(
            PlantPoint("", self.inertia, slope, self.coulomb, constant) for slope, constant in pairs
        )

    def to_text(self) -> str:
        """Return the plant as text for the log's metadata."""
        return json.dumps(vars(self))

    @staticmethod
    def of_text(text: str) -> LoggedPlant | None:
        """Return the plant from the text in a log's metadata; None if the text is invalid."""
        try:
            facts = json.loads(text)
            levels = {
                name: float(facts[name]) for name in ("inertia", "viscous", "coulomb", "constant")
            }
            slopes, constants = (
                tuple(float(value) for value in facts[name]) for name in ("slopes", "constants")
            )
        except (ValueError, KeyError, TypeError):
            return None
        plant = LoggedPlant(**levels, slopes=slopes, constants=constants)
        return plant if plant.is_possible else None


def intervals_to_text(intervals: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """Return the interval of each parameter as text for a log's metadata."""
    return {name: json.dumps(ends) for name, ends in intervals.items()}


def intervals_of_text(record: Mapping[str, str]) -> dict[str, tuple[float, float]]:
    """Return the interval of each parameter from a log's metadata.

    Entries other than two finite numbers are left out.
    """
    intervals = {}
    for name, text in record.items():
        try:
            low, high = (float(end) for end in json.loads(text))
        except (ValueError, TypeError):
            continue
        if math.isfinite(low) and math.isfinite(high):
            intervals[name] = (low, high)
    return intervals
