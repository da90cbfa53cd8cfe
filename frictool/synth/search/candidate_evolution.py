"""Differential evolution (Storn and Price 1997), strategy DE/best/1/bin.

A child replaces its parent if the child's value is not larger. The objective therefore gets the
parent's value as an argument. As soon as the child is worse than its parent, the objective may stop
and return a lower bound. `scipy.optimize.differential_evolution` does not provide the parent's
value. With the same random generator, scipy 1.17 draws the same points.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictool.typing import IntVector, Vector

# (point (d,), value of the parent) -> value, which is exact up to the value of the parent
Objective = Callable[[Vector, float], float]
FACTOR = (0.4, 0.9)  # range of the factor of differences, drawn once per generation
CROSSOVER = 0.8  # probability that a coordinate of the child is mutated
DRAWN = 6  # number of points drawn for each child; two of them are used


def evolve(objective: Objective, population: Vector, random: np.random.Generator) -> None:
    """Minimise an objective in the unit cube, until all points have the same value.

    population: points (p, d) of the first generation, p >= 3. For these points, the objective is
    called with infinity as the value of the parent. An exception of the objective ends the
    evolution.
    """
    units = population.copy()
    values = np.array([objective(unit, math.inf) for unit in population])
    indices = np.arange(len(units))
    _move_best_first(units, values)
    while True:
        factor = random.uniform(*FACTOR)
        for index in range(len(units)):
            child = _child(units, index, factor, indices, random)
            value = objective(child, float(values[index]))
            if value <= values[index]:
                units[index] = child
                values[index] = value
                if value <= values[0]:
                    _move_best_first(units, values)
        if np.ptp(values) == 0.0:
            return


def _move_best_first(units: Vector, values: Vector) -> None:
    best = int(np.argmin(values))
    units[[0, best]] = units[[best, 0]]
    values[[0, best]] = values[[best, 0]]


def _child(
    units: Vector, index: int, factor: float, indices: IntVector, random: np.random.Generator
) -> Vector:
    """Return a child of the point units[index].

    `indices` contains the indices of all points; this function shuffles it in place.
    """
    size = units.shape[1]
    mutated = random.integers(size)
    random.shuffle(indices)
    drawn = indices[:DRAWN]
    one, other = drawn[drawn != index][:2]
    taken = np.asarray(random.uniform(size=size) < CROSSOVER)
    taken[mutated] = True
    child = np.where(taken, units[0] + factor * (units[one] - units[other]), units[index])
    outside = (child < 0.0) | (child > 1.0)
    child[outside] = random.uniform(size=np.count_nonzero(outside))
    return np.asarray(child, dtype=np.float64)
