"""What a campaign varies: a box of factors, each between two ends; a draw is a point of the unit
cube, in which all are independent.

u in [0, 1]^d ──Space.values──▶ value of each factor ──campaign/drawing/drawn_scenario.py──▶ a
scenario that plays just this plant
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.documents.quantity import Quantity, Span, factor_between

Vector = NDArray[np.float64]
# of a plant: the model's parameters, a mechanism's quantities; what else the scenario's `spread`
# varies
Kind = Literal["plant", "wear", "temperature", "drive", "start", "sensor", "load"]


@dataclass(frozen=True)
class Factor:
    """One quantity that is drawn uniformly from [low, high], in SI as `unit` says ("1" of a pure
    number).

    name: its key, `coulomb`, `links.screw.backlash`, `spread.wear`; label: what people call it.
    nominal: where it is not varied. whole: it takes whole numbers only, each as likely as the
    others. least: (another factor, what it is multiplied by) that it may not fall below: it is
    drawn from what of its range lies above, so that the two are independent in the unit cube and
    not beyond it.
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

    def at(self, unit: Vector) -> Vector:
        """Its values (n,) for points (n,) of [0, 1]."""
        if self.whole:
            steps = np.floor(unit * (self.high - self.low + 1.0))
            return np.asarray(self.low + np.minimum(steps, self.high - self.low))
        return np.clip(self.low + unit * (self.high - self.low), self.low, self.high)


@dataclass(frozen=True)
class FactorSpace:
    """The factors in their order, each of which varies: low < high."""

    factors: tuple[Factor, ...]

    @property
    def size(self) -> int:
        """d, the number of factors."""
        return len(self.factors)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the factors."""
        return tuple(factor.name for factor in self.factors)

    def values(self, units: Vector) -> Vector:
        """Values (n, d) in SI for points (n, d) of the unit cube."""
        columns = [factor.at(units[:, index]) for index, factor in enumerate(self.factors)]
        for index, factor in enumerate(self.factors):
            if factor.least is not None:
                other, scale = factor.least
                low = np.maximum(factor.low, scale * columns[self.names.index(other)])
                columns[index] = low + units[:, index] * np.maximum(0.0, factor.high - low)
        return np.stack(columns, axis=1) if columns else np.empty((units.shape[0], 0))


class FactorRange(Protocol):
    """Where a parameter of a plant lies and is, in SI."""

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...

    @property
    def nominal(self) -> float: ...

    @property
    def unit(self) -> str: ...

    @property
    def label(self) -> str: ...

    @property
    def least(self) -> tuple[str, float] | None: ...


def plant_factors(
    ranges: Mapping[str, FactorRange], instead: Mapping[str, Span], given: Mapping[str, Quantity]
) -> Iterator[Factor]:
    """Those of a plant, by name; `instead`: ranges of some of them in place of its own, `given`:
    values of those that have none, in any unit of theirs.
    """
    ends = {name: _ends(own, instead.get(name), given.get(name)) for name, own in ranges.items()}
    for name, own in ranges.items():
        (low, high), least = ends[name], own.least
        if least is not None and low < high:
            below = ends[least[0]]
            if below[0] == below[1]:
                low, least = max(low, least[1] * below[0]), None
        yield Factor(name, low, high, own.unit, own.label, own.nominal, "plant", least=least)


def _ends(own: FactorRange, instead: Span | None, given: Quantity | None) -> tuple[float, float]:
    """Of a parameter [SI]."""
    if instead is not None:
        scale = factor_between(instead.unit, own.unit)
        return scale * instead.low, scale * instead.high
    if given is not None and own.low == own.high:
        value = factor_between(given.unit, own.unit) * given.value
        return value, value
    return own.low, own.high


def space_of(factors: Iterable[Factor]) -> FactorSpace:
    """The factors of which low < high."""
    return FactorSpace(tuple(factor for factor in factors if factor.low < factor.high))
