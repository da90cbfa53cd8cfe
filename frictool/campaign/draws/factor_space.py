"""Space of a campaign's factors, each with a range; a draw is a point of the unit cube.

u in [0, 1]^d ──FactorSpace.values──▶ factor values ──drawn_scenario.py──▶ scenario
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from frictool.documents.quantity import Quantity, Span, factor_between
from frictool.simulate.simulated_plant import VariedParameter
from frictool.typing import BoolVector, Vector

# `plant`: parameters of the model or mechanism; other kinds: from the scenario's `spread`
Kind = Literal["plant", "wear", "temperature", "drive", "start", "sensor", "load"]


@dataclass(frozen=True)
class Factor:
    """Quantity that is drawn uniformly from [low, high], in the SI unit `unit` ("1" if none).

    `name`: key of the quantity, such as `coulomb`, `links.screw.backlash` or `spread.wear`.
    `label`: name for users.
    `nominal`: value without variation.
    `whole`: True if all values are whole numbers, which are equally likely.
    `least`: (other factor, scale); scale times the value of the other factor is a lower limit. The
    factor is drawn from the part of its range above this limit. The two factors are therefore
    independent in the unit cube, but not in SI.
    """

    name: str
    low: float
    high: float
    unit: str
    label: str
    nominal: float
    kind: Kind
    whole: bool = False
    least: tuple[str, float] | None = None


@dataclass(frozen=True)
class FactorSpace:
    """Factors of a campaign in a fixed order; each of them varies (low < high)."""

    factors: tuple[Factor, ...]

    @property
    def size(self) -> int:
        """Return the number of factors d."""
        return len(self.factors)

    def values(self, units: Vector) -> Vector:
        """Return factor values (n, d) in SI for points (n, d) of the unit cube."""
        low, high, whole = self._ends
        values = np.clip(low + units * (high - low), low, high)
        steps = np.floor(units[:, whole] * (high[whole] - low[whole] + 1.0))
        values[:, whole] = low[whole] + np.minimum(steps, high[whole] - low[whole])
        for index, factor in enumerate(self.factors):
            if factor.least is not None:
                other, scale = factor.least
                least = np.maximum(factor.low, scale * values[:, self.names.index(other)])
                values[:, index] = least + units[:, index] * np.maximum(0.0, factor.high - least)
        return np.asarray(values)

    @cached_property
    def _ends(self) -> tuple[Vector, Vector, BoolVector]:
        """Lowest and highest value of each factor, and which take whole numbers only, (d,) each."""
        return (
            np.array([factor.low for factor in self.factors]),
            np.array([factor.high for factor in self.factors]),
            np.array([factor.whole for factor in self.factors], dtype=bool),
        )

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the names of the factors."""
        return tuple(factor.name for factor in self.factors)


def plant_factors(
    ranges: Mapping[str, VariedParameter],
    instead: Mapping[str, Span],
    fixed: Mapping[str, Quantity],
) -> Iterator[Factor]:
    """Yield the factors of a plant's parameters.

    `instead`: ranges by parameter that replace those of the plant. `fixed`: values of parameters
    without a range, in any suitable unit.
    """
    ends = {
        name: _ends(entry, instead.get(name), fixed.get(name)) for name, entry in ranges.items()
    }
    for name, entry in ranges.items():
        (low, high), least = ends[name], entry.least
        if least is not None and low < high:
            below = ends[least[0]]
            if below[0] == below[1]:
                low = max(low, least[1] * below[0])
                least = None
        yield Factor(name, low, high, entry.unit, entry.label, entry.nominal, "plant", least=least)


def _ends(
    entry: VariedParameter, instead: Span | None, fixed: Quantity | None
) -> tuple[float, float]:
    """Return (low, high) of a parameter in SI."""
    if instead is not None:
        scale = factor_between(instead.unit, entry.unit)
        return scale * instead.low, scale * instead.high
    if fixed is not None and entry.low == entry.high:
        value = factor_between(fixed.unit, entry.unit) * fixed.value
        return value, value
    return entry.low, entry.high


def space_of(factors: Iterable[Factor]) -> FactorSpace:
    """Return the space of those factors with low < high."""
    return FactorSpace(tuple(factor for factor in factors if factor.low < factor.high))
