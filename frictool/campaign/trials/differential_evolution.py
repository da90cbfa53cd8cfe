"""Search for the worst case of one metric in the space of factors.

The search starts from the worst draws and has two stages:

1. One factor after another is moved to an end of its range, as long as the metric gets worse.
2. Differential evolution continues from the points of stage 1.

The search uses no gradients, because the metric can jump where a change of the factors adds or
removes a stop or a breakaway of the axis. The algorithm of stage 2 is JADE (Zhang and Sanderson
2009). Points outside the unit cube are moved to its faces. The result is the worst evaluated point,
not necessarily the worst point of the space.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.typing import Vector

# returns the badness of the metric at a point of the unit cube: larger is worse, -inf if the metric
# has no value
Badness = Callable[[Vector], float]
WORST_STREAM = (1 << 33) + 5
LEAST_POPULATION, MOST_POPULATION = 8, 40
CORNERS = 0.4  # largest share of the evaluations for stage 1
BEST, LEARNING = 0.2, 0.1  # p and c of JADE


class SearchResult(NamedTuple):
    """Result of a worst-case search.

    `value`: worst value of the metric in the search.
    `drawn`: worst value of the metric in the draws.
    `unit` (d,): worst point in the unit cube.
    `noise`: index of the draw whose noise is used for all plants of the search.
    `evaluations`: number of plants that were tried.
    `unplayed`: number of these plants that could not be simulated.
    """

    name: str
    value: float
    drawn: float
    unit: tuple[float, ...]
    noise: int
    evaluations: int
    unplayed: int


class SearchState:
    """Number of evaluations of a search, and worst point so far.

    The badness of a point is the metric's value, with the sign for which a larger value is worse.
    """

    def __init__(self, badness: Badness, evaluations: int) -> None:
        self._badness = badness
        self.left = evaluations
        self.tried = 0
        self.worst = -math.inf
        self.at = np.empty(0)

    @property
    def ended(self) -> bool:
        """Return True if no evaluation is left, or if the worst point has infinite badness."""
        return self.left <= 0 or self.worst == math.inf

    def at_point(self, unit: Vector) -> float:
        """Return the badness at the point `unit` (d,); update the worst point."""
        self.left = self.left - 1
        self.tried = self.tried + 1
        badness = self._badness(unit)
        if badness > self.worst or not self.at.size:
            self.worst = badness
            self.at = unit.copy()
        return badness


def search_worst(badness: Badness, starts: Vector, evaluations: int, seed: int) -> SearchState:
    """Search for the worst point (d,) with at most `evaluations` evaluations.

    `starts` (k, d) are the worst draws, k >= 1.
    """
    generator = np.random.Generator(np.random.PCG64([seed, WORST_STREAM]))
    state = SearchState(badness, evaluations)
    known = [(unit.copy(), state.at_point(unit)) for unit in starts[:evaluations]]
    known += _to_corners(state, generator, round(CORNERS * evaluations))
    _evolve(state, known, generator)
    return state


def _to_corners(
    state: SearchState, generator: np.random.Generator, most: int
) -> list[tuple[Vector, float]]:
    """Move the factors of the worst point to ends of their ranges, as long as the metric worsens.

    Return (point, badness) of each evaluated point.
    """
    known = list[tuple[Vector, float]]()
    last = state.tried + most
    while not state.ended and state.tried < last:
        before = state.worst
        for factor in generator.permutation(state.at.size):
            for side in (0.0, 1.0):
                if state.at[factor] == side or state.ended or state.tried >= last:
                    continue
                unit = state.at.copy()
                unit[factor] = side
                known.append((unit, state.at_point(unit)))
        if state.worst == before:
            break
    return known


def _evolve(
    state: SearchState, known: list[tuple[Vector, float]], generator: np.random.Generator
) -> None:
    factors = state.at.size
    size = min(
        max(LEAST_POPULATION, 3 * factors), MOST_POPULATION, max(LEAST_POPULATION, state.left // 4)
    )
    known = sorted(known, key=lambda one: -one[1])[: max(1, size // 2)]
    while len(known) < size and not state.ended:
        unit = generator.random(factors)
        known.append((unit, state.at_point(unit)))
    units, values = np.stack([unit for unit, _ in known]), np.array([value for _, value in known])
    step, crossover = 0.5, 0.5
    while not state.ended and len(known) > 3:
        steps, crossovers = [], []
        for index in range(len(known)):
            if state.ended:
                return
            f = _cauchy(generator, step)
            cr = float(np.clip(generator.normal(crossover, 0.1), 0.0, 1.0))
            unit = _child(units, values, index, f, cr, generator)
            value = state.at_point(unit)
            if value >= values[index]:
                if value > values[index]:
                    steps.append(f)
                    crossovers.append(cr)
                units[index], values[index] = unit, value
        if steps:  # Lehmer mean, which favours long steps
            step = (1.0 - LEARNING) * step + LEARNING * sum(f * f for f in steps) / sum(steps)
            crossover = (1.0 - LEARNING) * crossover + LEARNING * float(np.mean(crossovers))


def _cauchy(generator: np.random.Generator, centre: float) -> float:
    while True:
        value = centre + 0.1 * math.tan(math.pi * (generator.random() - 0.5))
        if value > 0.0:
            return min(value, 1.0)


def _child(
    units: Vector, values: Vector, index: int, f: float, cr: float, generator: np.random.Generator
) -> Vector:
    size, factors = units.shape
    leaders = np.argsort(-values, kind="stable")[: max(2, round(BEST * size))]
    best = int(generator.choice(leaders))
    one, other = generator.choice([k for k in range(size) if k != index], 2, replace=False)
    moved = units[index] + f * (units[best] - units[index]) + f * (units[one] - units[other])
    taken = np.asarray(generator.random(factors) < cr)
    taken[generator.integers(factors)] = True
    child: Vector = np.where(taken, np.clip(moved, 0.0, 1.0), units[index])
    return child
