"""Search for the worst closed loop inside the box of plants: scattered points and a local search.

The box contains every plant whose parameters are in given intervals; the vertices are the plants at
the ends of the intervals. The result is a lower bound of the worst norm in the box, not a proof.
Upper bounds are computed in verify/zero_exclusion.py (constant parameters) and lmi/common_bound.py
(parameters that vary with time).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import DYNAMIC, Box, enclosing_box
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import largest
from frictool.verify.document_check import loop_checks
from frictool.verify.feedback_loops import FeedbackLoop
from frictool.verify.hinf_norm import norm

PRIMES = (2, 3, 5, 7)
NAMES = (*DYNAMIC, "coulomb")
POINTS = 300  # points inside the box
SEED = 1
STEPS = 30  # iterations; each halves the steps of parameters that do not increase the norm


@dataclass(frozen=True)
class WorstPlant:
    """Plant with the largest norm of all examined plants, and this norm (inf if unstable)."""

    norm: float
    point: PlantPoint


def interior_points(box: Box, count: int, seed: int) -> tuple[PlantPoint, ...]:
    """Return `count` plants spread evenly inside the parameter intervals `box`.

    The points are a Halton sequence shifted by a random vector (Cranley and Patterson, 1976).
    """
    shift = np.random.default_rng(seed).random(len(NAMES))
    index = np.arange(1, count + 1)
    unit = (np.column_stack([_radical_inverse(index, base) for base in PRIMES]) + shift) % 1.0
    return tuple(
        _point(f"i{k:0{len(str(count))}d}", box, row) for k, row in enumerate(unit, start=1)
    )


def _radical_inverse(index: NDArray[np.int64], base: int) -> NDArray[np.float64]:
    """Return the number in [0, 1) with the digits of `index` in reverse order, in base `base`."""
    inverse = np.zeros(len(index))
    share = 1.0 / base
    rest = index.copy()
    while np.any(rest):
        inverse += share * (rest % base)
        rest = rest // base
        share = share / base
    return inverse


def _point(name: str, box: Box, unit: NDArray[np.float64]) -> PlantPoint:
    values = {
        key: low + float(part) * (high - low)
        for (key, (low, high)), part in zip(((n, box[n]) for n in NAMES), unit, strict=True)
    }
    return PlantPoint(
        name, values["inertia"], values["viscous"], values["coulomb"], values["constant"]
    )


def worst_inside(
    controller: Lti, plant: Callable[[AxisRates], GeneralisedPlant], vertices: Sequence[PlantPoint]
) -> tuple[WorstPlant, WorstPlant]:
    """Return the worst vertex, and the worst plant of a search at and between the vertices.

    The search evaluates the vertices and POINTS scattered plants between them. A local search then
    starts at the worst of all these plants.
    """
    box = enclosing_box(vertices)
    at_vertices = worst_norm(controller, plant, vertices)
    inside = worst_norm(controller, plant, interior_points(box, points_inside(vertices), SEED))
    start = (at_vertices, inside)[largest((at_vertices.norm, inside.norm))[1]]
    return at_vertices, searched(controller, plant, box, start)


def worst_sensitivity(
    loops: Sequence[FeedbackLoop], lag: float, delay: int, vertices: Sequence[PlantPoint]
) -> tuple[float, float, PlantPoint]:
    """Return the largest sensitivity at the vertices, then the largest between them and its plant.

    Between the vertices, POINTS scattered plants are evaluated. The returned plant has the largest
    sensitivity of these scattered plants.

    - lag: time constant of the drive [s]
    - delay: computational delay [samples]
    """

    def sensitivity(point: PlantPoint) -> float:
        margin = loop_checks(loops, point, lag, (delay,))[0].modulus_margin
        return 1.0 / margin if margin > 0.0 else np.inf

    points = interior_points(enclosing_box(vertices), points_inside(vertices), SEED)
    inside, at = largest(map(sensitivity, points))
    return max(map(sensitivity, vertices)), inside, points[at]


def points_inside(vertices: Sequence[PlantPoint]) -> int:
    """Return the number of plants to evaluate between the vertices.

    The number is POINTS, or 1 if there is only one vertex.
    """
    return POINTS if len(vertices) > 1 else 1


def worst_norm(
    controller: Lti, plant: Callable[[AxisRates], GeneralisedPlant], points: Sequence[PlantPoint]
) -> WorstPlant:
    """Return the plant with the largest norm among the points.

    `plant` is a function from AxisRates (parameters divided by the inertia) to the generalised
    plant in the controller's time domain.
    """
    value, at = largest(norm(plant(point.rates).closed(controller))[0] for point in points)
    return WorstPlant(value, points[at])


def searched(
    controller: Lti, plant: Callable[[AxisRates], GeneralisedPlant], box: Box, start: WorstPlant
) -> WorstPlant:
    """Return the worst plant of a coordinate search from `start` within the intervals `box`.

    The search maximises the norm of the closed loop.
    """
    low, high = (np.array([box[name][side] for name in NAMES]) for side in (0, 1))
    width = np.where(high > low, high - low, 1.0)
    at = np.clip((np.array([getattr(start.point, name) for name in NAMES]) - low) / width, 0.0, 1.0)
    best = start
    step = np.where(high > low, 0.25, 0.0)
    for _ in range(STEPS):
        if np.isinf(best.norm) or not np.any(step > 1e-3):
            break
        for axis in np.flatnonzero(step > 1e-3):
            tried = [
                np.clip(at + sign * step[axis] * np.eye(len(NAMES))[axis], 0.0, 1.0)
                for sign in (-1.0, 1.0)
            ]
            candidates = [
                (worst_norm(controller, plant, [_point("found", box, unit)]), unit)
                for unit in tried
            ]
            worst, unit = candidates[largest(pair[0].norm for pair in candidates)[1]]
            if worst.norm > best.norm * (1.0 + 1e-9):
                best, at = worst, unit
            else:
                step[axis] *= 0.5
    return best
