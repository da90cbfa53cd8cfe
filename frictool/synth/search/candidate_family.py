"""Family of designs of one structure and method, with dimensionless parameters for a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from frictool.documents.design import Design
from frictool.synth.search.design_scales import DesignScales
from frictool.typing import Vector

DIGITS = 4  # significant digits of every value of a design, so that its file is exact


@dataclass(frozen=True)
class SearchedParameter:
    """Dimensionless parameter that is searched between `low` and `high` on a logarithmic scale.

    starts: values at the starting points of the family's search, one for each starting point.
    """

    name: str
    low: float
    high: float
    starts: tuple[float, ...]


@dataclass(frozen=True)
class CandidateFamily:
    """Family of designs of one structure and method.

    - name: description of the family in messages
    - parameters: parameters that the search varies
    - design: `design(scales, values)` returns a design; `values` maps parameter names to numbers
    - candidates: largest number of candidates that the search simulates
    """

    name: str
    parameters: tuple[SearchedParameter, ...]
    design: Callable[[DesignScales, Mapping[str, float]], Design]
    candidates: int

    @property
    def starts(self) -> list[Vector]:
        """Return the starting points in the unit cube, each (d,) for d parameters."""
        count = len(self.parameters[0].starts)
        return [
            np.array([_unit(one, one.starts[index]) for one in self.parameters])
            for index in range(count)
        ]

    def values(self, unit: Vector) -> dict[str, float]:
        """Return the value of each parameter at a point (d,) of the unit cube."""
        inside = np.clip(unit, 0.0, 1.0)
        return {
            one.name: float(one.low * (one.high / one.low) ** share)
            for one, share in zip(self.parameters, inside, strict=True)
        }


def rounded(value: float) -> float:
    """Return a value rounded to DIGITS significant digits."""
    return float(f"{value:.{DIGITS}g}")


def _unit(one: SearchedParameter, value: float) -> float:
    return float(np.log(value / one.low) / np.log(one.high / one.low))
