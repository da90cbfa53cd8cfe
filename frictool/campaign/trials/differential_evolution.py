"""The worst case of one metric: where in the box of factors its margin is least, found by search.

    worst draws ──▶ corners: one factor after the other to an end, as long as it gets worse ──▶
    differential evolution ──▶ worst point

A margin jumps where a stop or a breakaway more or less takes place, and most often is worst at an
end of some factors and between the ends of others: there are no gradients to follow. The evolution
is JADE (Zhang and Sanderson 2009: current to one of the best, the step and the crossover learnt
from what succeeded), with steps beyond the box cut at its faces. It begins with what is known, so
that nothing that it gives is better than the worst draw. What it gives is the worst that was found,
not proved to be the worst there is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Badness = Callable[
    [Vector], float
]  # of a point of the cube; the larger, the worse; -inf where it has none
WORST_STREAM = (1 << 33) + 5
LEAST_POPULATION, MOST_POPULATION = 8, 40
CORNERS = 0.4  # of the evaluations go to corners at most
BEST, LEARNING = 0.2, 0.1  # p and c of the paper


class SearchResult(NamedTuple):
    """value: the worst of the metric `name`; drawn: the worst of the draws. unit (d,): where, in
    the cube.

    noise: number of the draw whose noise it has. evaluations: how many plants were tried; unplayed:
    of them that could not be simulated.
    """

    name: str
    value: float
    drawn: float
    unit: tuple[float, ...]
    noise: int
    evaluations: int
    unplayed: int


class SearchState:
    """Counts what is tried, and remembers the worst."""

    def __init__(self, badness: Badness, evaluations: int) -> None:
        self._badness, self.left, self.tried = badness, evaluations, 0
        self.worst, self.at = -math.inf, np.empty(0)

    @property
    def ended(self) -> bool:
        """Nothing is left, or nothing can be worse."""
        return self.left <= 0 or self.worst == math.inf

    def at_point(self, unit: Vector) -> float:
        """The badness at `unit` (d,)."""
        self.left, self.tried = self.left - 1, self.tried + 1
        found = self._badness(unit)
        if found > self.worst or not self.at.size:
            self.worst, self.at = found, unit.copy()
        return found


def search_worst(badness: Badness, starts: Vector, evaluations: int, seed: int) -> SearchState:
    """The worst of at most `evaluations` points (d,), from `starts` (k, d), the worst draws, k >=
    1."""
    generator, found = (
        np.random.Generator(np.random.PCG64([seed, WORST_STREAM])),
        SearchState(badness, evaluations),
    )
    known = [(unit.copy(), found.at_point(unit)) for unit in starts[:evaluations]]
    known += _to_corners(found, generator, round(CORNERS * evaluations))
    _evolve(found, known, generator)
    return found


def _to_corners(
    found: SearchState, generator: np.random.Generator, most: int
) -> list[tuple[Vector, float]]:
    """From the worst point each factor in turn to the end at which it is worse, until a whole round
    has changed nothing."""
    known, end = list[tuple[Vector, float]](), found.tried + most
    while not found.ended and found.tried < end:
        before = found.worst
        for factor in generator.permutation(found.at.size):
            for side in (0.0, 1.0):
                if found.at[factor] == side or found.ended or found.tried >= end:
                    continue
                unit = found.at.copy()
                unit[factor] = side
                known.append((unit, found.at_point(unit)))
        if found.worst == before:
            break
    return known


def _evolve(
    found: SearchState, known: list[tuple[Vector, float]], generator: np.random.Generator
) -> None:
    """Differential evolution of the worst of what is known, filled up with random points."""
    factors = found.at.size
    size = min(
        max(LEAST_POPULATION, 3 * factors), MOST_POPULATION, max(LEAST_POPULATION, found.left // 4)
    )
    known = sorted(known, key=lambda one: -one[1])[: max(1, size // 2)]
    while len(known) < size and not found.ended:
        unit = generator.random(factors)
        known.append((unit, found.at_point(unit)))
    units, values = np.stack([unit for unit, _ in known]), np.array([value for _, value in known])
    step, crossover = 0.5, 0.5
    while not found.ended and len(known) > 3:
        steps, crossovers = [], []
        for place in range(len(known)):
            if found.ended:
                return
            f, cr = (
                _cauchy(generator, step),
                float(np.clip(generator.normal(crossover, 0.1), 0.0, 1.0)),
            )
            unit = _child(units, values, place, f, cr, generator)
            value = found.at_point(unit)
            if value >= values[place]:
                if value > values[place]:
                    steps.append(f)
                    crossovers.append(cr)
                units[place], values[place] = unit, value
        if steps:  # Lehmer's mean favours long steps
            step = (1.0 - LEARNING) * step + LEARNING * sum(f * f for f in steps) / sum(steps)
            crossover = (1.0 - LEARNING) * crossover + LEARNING * float(np.mean(crossovers))


def _cauchy(generator: np.random.Generator, centre: float) -> float:
    """A step in (0, 1]: drawn anew where it is not positive."""
    while True:
        found = centre + 0.1 * math.tan(math.pi * (generator.random() - 0.5))
        if found > 0.0:
            return min(found, 1.0)


def _child(
    units: Vector, values: Vector, place: int, f: float, cr: float, generator: np.random.Generator
) -> Vector:
    """current-to-pbest/1 with binomial crossover, cut at the faces of the cube, where the worst
    often is."""
    size, factors = units.shape
    leaders = np.argsort(-values, kind="stable")[: max(2, round(BEST * size))]
    best = int(generator.choice(leaders))
    one, other = generator.choice([k for k in range(size) if k != place], 2, replace=False)
    moved = units[place] + f * (units[best] - units[place]) + f * (units[one] - units[other])
    taken = np.asarray(generator.random(factors) < cr)
    taken[generator.integers(factors)] = True
    found: Vector = np.where(taken, np.clip(moved, 0.0, 1.0), units[place])
    return found
