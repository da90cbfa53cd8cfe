"""Scheduled controller: interpolation between the controllers at the parameter corners.

Thesis (5.46) and (5.64) define the weights of the interpolation. The interpolated controller
satisfies the matrix inequalities of the synthesis only if the plants are affine in the parameters
(`vertices: first_order`, continuous time). The controller is therefore verified in the form that
runs on the target hardware, at the corners and at plants between the corners.
"""

from __future__ import annotations

from frictool.adapters.state_space import stored_state_space
from frictool.documents import controller as stored
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.synth.realisation import anti_windup_gains
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem
from frictool.verify.loop_wording import plant_words
from frictool.verify.scheduled_loop import scheduled_figures


def verified_schedule(problem: SynthesisProblem, candidate: ControllerCandidate) -> stored.Schedule:
    """Verify the scheduled controller of a candidate, and return it in its stored form.

    Raises NoSolutionError if the candidate has no scheduled controller, if the controller of a
    corner is unstable, or if a loop is unstable or has less than the specified modulus margin.
    """
    if candidate.over is None:
        raise NoSolutionError(
            f"method {problem.design.method} gives no scheduled controller; remove `scheduled`"
        )
    corners, names = candidate.over.vertices, candidate.over.scheduled
    for corner, k in zip(corners, candidate.scheduled, strict=True):
        if not k.stable:
            raise NoSolutionError(
                f"the controller of vertex {corner.name} is itself unstable, so that its states "
                "grow whenever the loop is open; "
                "raise weights.static_error, or remove `scheduled`"
            )
    stored_corners = tuple(
        _corner(corner, k) for corner, k in zip(corners, candidate.scheduled, strict=True)
    )
    figures = scheduled_figures(
        stored_corners, names, problem.running, problem.lag, problem.delay, problem.period
    )
    required = problem.spec.modulus_margin or 0.0
    if figures.modulus_margin <= 0.0 or figures.modulus_margin < required:
        raise NoSolutionError(
            "not verified: the scheduled loop has a modulus margin of "
            f"{figures.modulus_margin:.3f} < {required:g} at "
            f"{plant_words(figures.at, problem.model.bench)}; "
            "relax the weights"
        )
    return stored.Schedule(
        names, stored_corners, figures.gamma, figures.modulus_margin, figures.points
    )


def _corner(point: PlantPoint, k: Lti) -> stored.Corner:
    gains = tuple(float(value) for value in anti_windup_gains(k.a, k.b, k.c, k.d))
    return stored.Corner(
        point.inertia, point.viscous, point.coulomb, point.constant, stored_state_space(k), gains
    )
