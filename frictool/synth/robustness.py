"""Worst norm within the parameter box, and a bound for parameters that vary with time."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.lmi.common_bound import common_bound
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import corners, enclosing_box
from frictool.synth.synthesis_problem import SynthesisProblem
from frictool.verify.feedback_loops import FeedbackLoop
from frictool.verify.interior_search import points_inside, worst_inside, worst_sensitivity
from frictool.verify.loop_values import CLAIM
from frictool.verify.loop_wording import plant_words


def robustness(
    problem: SynthesisProblem, system: Lti, *, varying: bool = False
) -> stored.Robustness:
    """Return the largest norm found at and between the vertices with the controller `system`.

    varying: True to return also a bound for parameters that vary arbitrarily fast. Raises
    NoSolutionError if the loop is unstable for a plant of the box, or if the norm is more than 1 %
    above the largest norm at the vertices.
    """
    vertices, worst = worst_inside(system, problem.running, problem.box.vertices)
    if math.isinf(worst.norm):
        raise NoSolutionError(
            "not verified: the sampled loop is unstable inside the box, at "
            f"{plant_words(worst.point, problem.model.bench)}; "
            "narrow the intervals, or relax the weights"
        )
    if worst.norm > CLAIM * vertices.norm:
        raise NoSolutionError(
            f"not verified: the norm is {worst.norm:.4g} inside the box, at "
            f"{plant_words(worst.point, problem.model.bench)}, "
            f"above {vertices.norm:.4g} at the vertices; narrow the intervals or relax the weights"
        )
    common = None
    if varying:
        box = enclosing_box(problem.box.vertices)
        loops = [problem.running(point.rates).closed(system) for point in corners(box)]
        common = _finite_or_none(common_bound(loops))
    return stored.Robustness(
        interior_points=points_inside(problem.box.vertices),
        interior=worst.norm,
        common=common,
    )


def sensitivity_inside(
    problem: SynthesisProblem, loops: Sequence[FeedbackLoop]
) -> stored.Robustness:
    """Return the largest sensitivity found at and between the vertices.

    Between the vertices, scattered plants are evaluated; the result is not an upper bound. Raises
    NoSolutionError if a loop is unstable for one of these plants, or if the sensitivity is more
    than 1 % above the largest sensitivity at the vertices.
    """
    vertices, inside, at = worst_sensitivity(
        loops, problem.lag, problem.delay, problem.box.vertices
    )
    if inside > CLAIM * vertices:
        raise NoSolutionError(
            f"not verified: the largest sensitivity is {inside:.4g} inside the box, at "
            f"{plant_words(at, problem.model.bench)}, "
            f"above {vertices:.4g} at the vertices; narrow the intervals"
        )
    return stored.Robustness(
        interior_points=points_inside(problem.box.vertices), interior=max(inside, vertices)
    )


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None
