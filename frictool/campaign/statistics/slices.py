"""The draws of a factor in slices of equal counts, in its order: what every estimate of its
influence compares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.trials.trials import Trials

Vector = NDArray[np.float64]
Places = NDArray[np.int64]
FEWEST, TENTHS, MOST = 3, 10, 60


@dataclass(frozen=True)
class Slices:
    """of (n,): the number of the slice that each draw is in, 0..count - 1; every slice has a draw
    at least."""

    of: Places
    count: int

    def sums(self, values: Vector) -> Vector:
        """(count,) of values (n,)."""
        return np.asarray(np.bincount(self.of, weights=values, minlength=self.count), dtype=float)

    @property
    def sizes(self) -> Places:
        """(count,) draws in each."""
        return np.bincount(self.of, minlength=self.count)


def slices_for(draws: int) -> int:
    """How many for a share: 3 n^(1/3), so that what varies inside of a slice and what is noise of
    its mean shrink together."""
    return int(np.clip(round(3.0 * draws ** (1.0 / 3.0)), FEWEST, MOST))


def few_slices_for(draws: int) -> int:
    """How many for a decision: few, since what is spread over many is hardly seen; a dozen draws in
    each at least, where there are so many.
    """
    return int(np.clip(draws // 12, FEWEST, TENTHS))


class SortedDraws:
    """The draws of trials, each factor sorted once for all the comparisons that slice it."""

    def __init__(self, trials: Trials) -> None:
        self._trials = trials
        self._orders = [np.argsort(column, kind="stable") for column in trials.units.T]
        self._few = [
            factor.whole or _at_ends(column)
            for factor, column in zip(trials.space.factors, trials.units.T, strict=True)
        ]

    def sliced(self, factor: int, count: int, chosen: NDArray[np.bool_]) -> Slices:
        """The draws `chosen` (n,) of a factor, in `count` slices; in one for each value where it
        has no more values than that."""
        if self._few[factor]:
            where = (
                self._trials.values
                if self._trials.space.factors[factor].whole
                else self._trials.units
            )
            values, of = np.unique(where[chosen, factor], return_inverse=True)
            if values.size <= count:
                return Slices(of.astype(np.int64), int(values.size))
        ordered = self._orders[factor][chosen[self._orders[factor]]]
        count = min(count, ordered.size)
        places = np.empty(chosen.size, dtype=np.int64)
        places[ordered] = np.arange(ordered.size) * count // max(ordered.size, 1)
        return Slices(places[chosen], count)


def cross_slices(first: Slices, second: Slices) -> Slices:
    """The cells of two factors; those without a draw are left out."""
    cell = first.of * second.count + second.of
    filled = np.bincount(cell, minlength=first.count * second.count) > 0
    return Slices((np.cumsum(filled) - 1)[cell], int(filled.sum()))


def _at_ends(units: Vector) -> bool:
    return bool(np.all((units == 0.0) | (units == 1.0)))
