"""Slices of a factor's range with equal numbers of draws, from which influences are estimated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.campaign.trials.trials import Trials
from frictool.typing import IntVector, Vector

FEWEST, TENTHS, MOST = 3, 10, 60


@dataclass(frozen=True)
class Slices:
    """Assignment of draws to slices.

    `of` (n,): index of the slice of each draw, 0 to count - 1; no slice is empty.
    """

    of: IntVector
    count: int

    def sums(self, values: Vector) -> Vector:
        """Return the sums (count,) of `values` (n,) in each slice."""
        return np.asarray(np.bincount(self.of, weights=values, minlength=self.count), dtype=float)

    @property
    def sizes(self) -> IntVector:
        """Return the numbers (count,) of draws in each slice."""
        return np.bincount(self.of, minlength=self.count)


def slices_for(draws: int) -> int:
    """Return the number of slices for the estimate of a variance share: 3 n^(1/3) for n `draws`.

    As n grows, the variation within a slice decreases, and so does the noise of the slice's mean.
    """
    return int(np.clip(round(3.0 * draws ** (1.0 / 3.0)), FEWEST, MOST))


def few_slices_for(draws: int) -> int:
    """Return the number of slices for a test of whether a factor influences a metric.

    Each slice has at least 12 draws if possible. With more slices, an effect is harder to detect.
    """
    return int(np.clip(draws // 12, FEWEST, TENTHS))


class SortedDraws:
    """Draws of the trials, sorted once by each factor."""

    def __init__(self, trials: Trials) -> None:
        self._trials = trials
        self._orders = [np.argsort(column, kind="stable") for column in trials.units.T]
        self._few = [
            factor.whole or _at_ends(column)
            for factor, column in zip(trials.space.factors, trials.units.T, strict=True)
        ]

    def sliced(self, factor: int, count: int, chosen: NDArray[np.bool_]) -> Slices:
        """Return `count` slices of a factor's range, for the draws in the mask `chosen` (n,).

        If the factor has at most `count` different values, such as a few whole numbers or only the
        ends of its range, each value is a slice.
        """
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
    """Return the non-empty intersections of the slices of two factors."""
    cell = first.of * second.count + second.of
    filled = np.bincount(cell, minlength=first.count * second.count) > 0
    return Slices((np.cumsum(filled) - 1)[cell], int(filled.sum()))


def _at_ends(units: Vector) -> bool:
    return bool(np.all((units == 0.0) | (units == 1.0)))
