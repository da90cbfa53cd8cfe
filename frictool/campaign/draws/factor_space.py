"""Space of the factors (varied quantities) of a campaign; a draw is a point u of the unit cube.

u in [0, 1]^d ──FactorSpace.values──▶ factor values ──drawn_scenario.py──▶ scenario
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from frictool.documents.quantity import Quantity, Span, factor_between
from frictool.simulate.parameter_order import drawn_above
from frictool.simulate.simulated_plant import VariedParameter
from frictool.typing import IntVector, Vector

# `plant`: parameter of the model or mechanism; the other kinds are keys of the scenario's `spread`
Kind = Literal["plant", "wear", "temperature", "drive", "start", "sensor", "load"]


@dataclass(frozen=True)
class Factor:
    """Quantity that is drawn uniformly from [low, high], in the SI unit `unit` ("1" if none).

    `name`: key of the quantity, such as `coulomb`, `links.screw.backlash` or `spread.wear`.
    `label`: name for users.
    `nominal`: value if the quantity does not vary.
    `kind`: `plant` for a parameter of the plant, else the varied effect, such as `wear` or
        `sensor`.
    `whole`: True if the values are whole numbers, all equally likely.
    `least`: (name of another factor, scale). The least value of this factor is scale times the
        value of the other factor. None if there is no such condition.
    `ratio`: range of the quotient (value of this factor)/(its least value). If the range is not
        None, this quotient is drawn uniformly instead of the value; low and high are the smallest
        and the largest resulting values.
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
    ratio: tuple[float, float] | None = None


@dataclass(frozen=True)
class FactorSpace:
    """Factors of a campaign in a fixed order; every factor varies (low < high)."""

    factors: tuple[Factor, ...]

    @property
    def size(self) -> int:
        """Return the number of factors d."""
        return len(self.factors)

    def values(self, units: Vector) -> Vector:
        """Convert points `units` (n, d) of the unit cube to factor values (n, d) in SI."""
        low, high, whole = self._bounds
        values = np.minimum(np.maximum(low + units * (high - low), low), high)
        if whole.size:
            steps = np.floor(units[:, whole] * (high[whole] - low[whole] + 1.0))
            values[:, whole] = low[whole] + np.minimum(steps, high[whole] - low[whole])
        for index, factor in enumerate(self.factors):
            if factor.least is not None:
                other, scale = factor.least
                limits = scale * values[:, self.names.index(other)]
                bounds = (factor.low, factor.high)
                values[:, index] = drawn_above(bounds, factor.ratio, limits, units[:, index])
        return np.asarray(values)

    @cached_property
    def _bounds(self) -> tuple[Vector, Vector, IntVector]:
        return (
            np.array([factor.low for factor in self.factors]),
            np.array([factor.high for factor in self.factors]),
            np.flatnonzero([factor.whole for factor in self.factors]),
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
    """Yield the factors of a plant's parameters, including factors with low equal to high.

    `ranges`: range of each parameter in the plant document.
    `instead`: ranges that replace those of the document, by parameter.
    `fixed`: values that replace those of the document, for parameters without a range.
    """
    bounds = {
        name: _bounds(entry, instead.get(name), fixed.get(name)) for name, entry in ranges.items()
    }
    for name, entry in ranges.items():
        (low, high), least = bounds[name], entry.least
        ratio = None if name in instead else entry.ratio
        if least is not None and low < high:
            below = bounds[least[0]]
            if ratio is not None:
                low, high = (least[1] * ratio[side] * below[side] for side in (0, 1))
            if below[0] == below[1]:
                low = max(low, least[1] * below[0])
                least = ratio = None
        yield Factor(
            name,
            low,
            high,
            entry.unit,
            entry.label,
            entry.nominal,
            "plant",
            least=least,
            ratio=ratio,
        )


def _bounds(
    entry: VariedParameter, instead: Span | None, fixed: Quantity | None
) -> tuple[float, float]:
    if instead is not None:
        scale = factor_between(instead.unit, entry.unit)
        return scale * instead.low, scale * instead.high
    if fixed is not None and entry.low == entry.high:
        value = factor_between(fixed.unit, entry.unit) * fixed.value
        return value, value
    return entry.low, entry.high


def space_of(factors: Iterable[Factor]) -> FactorSpace:
    """Return the space of those factors that vary (low < high)."""
    return FactorSpace(tuple(factor for factor in factors if factor.low < factor.high))
