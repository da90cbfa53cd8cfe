"""The scheduled controller: the corners' matrices summed with the weights of the plant's parameters (5.46), (5.64).

The inequalities cover it where the plants are affine in the parameters (vertices: first_order, continuous time). Elsewhere, exact
vertices or sampled plants, they cover it nearly: it is verified at the corners and at plants between them, as it runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.plant.box import enclosing
from frictool.plant.lti import Lti
from frictool.plant.polytope import PARAMETERS, PlantPoint
from frictool.synth.problem import Candidate, Problem
from frictool.synth.realisation import anti_windup_gains
from frictool.verify.interior import interior_points
from frictool.verify.speed_loop import check_loop, performance
from frictool.verify.words import plant_words

POINTS = 100  # between the corners
SEED = 2
NAMES = tuple(name for name in PARAMETERS if name != "regime")
Corners = Sequence[stored.Corner | PlantPoint]


def weights(corners: Corners, names: Sequence[str], point: PlantPoint) -> NDArray[np.float64]:
    """alpha_i of (5.46), (k,): not negative, their sum is 1. A parameter outside its interval counts as at its end.

    alpha_i is the product over the parameters of the distance to the opposite end, over the width; an interval of no width has no share.
    """
    found = np.ones(len(corners))
    for name in names:
        values = np.array([getattr(corner, name) for corner in corners])
        low, high = float(values.min()), float(values.max())
        if high > low:
            share = (min(max(getattr(point, name), low), high) - low) / (high - low)
            found *= np.where(values == high, share, 1.0 - share)
    return found


def at(controllers: Sequence[Lti], alpha: NDArray[np.float64]) -> Lti:
    """The controller of the weights `alpha` (5.64)."""
    a, b, c, d = (sum((x * getattr(k, part) for x, k in zip(alpha, controllers, strict=True)), start=np.zeros(())) for part in "abcd")
    return Lti(a, b, c, d, controllers[0].period)


def verified_schedule(problem: Problem, candidate: Candidate) -> stored.Schedule:
    """Raises NoSolutionError where a corner's controller is unstable by itself, or a loop is unstable or short of the specified margin."""
    if candidate.over is None:
        raise NoSolutionError(f"method {problem.design.method} found no controllers to be scheduled")
    corners, names = candidate.over.vertices, candidate.over.scheduled
    for corner, k in zip(corners, candidate.scheduled, strict=True):
        if not k.stable:
            raise NoSolutionError(
                f"the controller of vertex {corner.name} is itself unstable, and would run away whenever the loop is open; "
                "raise weights.static_error, or leave out scheduled"
            )
    required, gamma, margin = problem.spec.modulus_margin or 0.0, 0.0, np.inf
    for point in (*corners, *interior_points(enclosing(corners), POINTS, SEED)):
        k = at(candidate.scheduled, weights(corners, names, point))
        check = check_loop(k, point.rates, problem.lag, problem.delay)
        if not check.stable or check.modulus_margin < required:
            raise NoSolutionError(
                f"not verified: the scheduled loop has a modulus margin of {check.modulus_margin:.3f} < {required:g} at "
                f"{plant_words(point, problem.model.bench)}; "
                "relax the weights"
            )
        gamma, margin = max(gamma, performance(k, problem.running(point.rates))), min(margin, check.modulus_margin)
    return stored.Schedule(
        parameters=names,
        corners=tuple(_corner(corner, k) for corner, k in zip(corners, candidate.scheduled, strict=True)),
        gamma=gamma,
        modulus_margin=margin,
        points=POINTS,
    )


def _corner(point: PlantPoint, k: Lti) -> stored.Corner:
    gains = tuple(float(value) for value in anti_windup_gains(k.a, k.b, k.c, k.d))
    return stored.Corner(point.inertia, point.viscous, point.coulomb, point.constant, k.document(), gains)
