"""The worst norm over every plant of the box, beside that of its vertices: seen inside, and bounded from above in three senses."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.lmi.lyapunov_bounds import common_bound, parameter_dependent_bound
from frictool.lmi.structured import worst_gain
from frictool.plant.box import corners, enclosing
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.plant.uncertain_axis import uncertain_plant
from frictool.synth.problem import CLAIM, Problem
from frictool.ties import largest
from frictool.verify.controller import loop_checks
from frictool.verify.effective import Feedback
from frictool.verify.interior import interior_points, searched, worst_norm
from frictool.verify.words import plant_words

POINTS = 300  # inside the box
SEED = 1


def robustness(problem: Problem, system: Lti) -> stored.Robustness:
    """Of the sampled loop that `system` closes. Raises NoSolutionError where a plant inside is unstable, or 1 % above the vertices."""
    box = enclosing(problem.box.vertices)
    vertices = worst_norm(system, problem.running, problem.box.vertices)
    inside = worst_norm(system, problem.running, interior_points(box, _count(problem), SEED))
    worst = searched(system, problem.running, box, (vertices, inside)[largest((vertices.norm, inside.norm))[1]])
    if math.isinf(worst.norm):
        raise NoSolutionError(
            f"not verified: the sampled loop is unstable inside the box, at {plant_words(worst.point, problem.model.bench)}; "
            "narrow the intervals, or relax the weights"
        )
    if worst.norm > CLAIM * vertices.norm:
        raise NoSolutionError(
            f"not verified: the norm is {worst.norm:.4g} inside the box, at {plant_words(worst.point, problem.model.bench)}, "
            f"where {vertices.norm:.4g} is claimed; narrow the intervals or relax the weights"
        )
    plant, blocks = uncertain_plant(problem.controlled, box, problem.lag, problem.weights, problem.period, problem.delay)
    loops = [problem.running(point.rates).closed(system) for point in corners(box)]
    return stored.Robustness(
        interior_points=_count(problem),
        interior=worst.norm,
        structured=_found(worst_gain(plant.closed(system), blocks, worst.norm).value),
        parameter_dependent=_found(parameter_dependent_bound(loops).gamma),
        common=_found(common_bound(loops).gamma),
    )


def seen_inside(problem: Problem, loops: Sequence[Feedback]) -> stored.Robustness:
    """The worst sensitivity that is seen inside, where no weighted norm is claimed; there is no bound then.

    Raises NoSolutionError where a plant inside is unstable, or 1 % above the vertices.
    """

    def sensitivity(point: PlantPoint) -> float:
        margin = loop_checks(loops, point, problem.lag, (problem.delay,))[0].modulus_margin
        return 1.0 / margin if margin > 0.0 else math.inf

    points = interior_points(enclosing(problem.box.vertices), _count(problem), SEED)
    vertices = max(map(sensitivity, problem.box.vertices))
    inside, at = largest(map(sensitivity, points))
    if inside > CLAIM * vertices:
        raise NoSolutionError(
            f"not verified: the largest sensitivity is {inside:.4g} inside the box, at {plant_words(points[at], problem.model.bench)}, "
            f"where {vertices:.4g} is claimed; narrow the intervals"
        )
    return stored.Robustness(interior_points=_count(problem), interior=max(inside, vertices))


def _count(problem: Problem) -> int:
    """One where nothing is uncertain: there is no other plant."""
    return POINTS if len(problem.box.vertices) > 1 else 1


def _found(value: float) -> float | None:
    return value if math.isfinite(value) else None
