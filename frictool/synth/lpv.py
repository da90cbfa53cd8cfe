"""Method `lpv`: common Lyapunov matrices over the polytope's vertices (thesis 5.3.1).

The inequalities give a controller for each plant of the polytope. The target hardware runs only one
of these controllers: the controller of the plant `frozen_at` in the design (thesis 5.64-5.65). For
other plants, the inequalities guarantee nothing with this frozen controller. The sampled loop is
therefore rebuilt from the stored coefficients and verified at every vertex.
"""

from __future__ import annotations

import numpy as np

from frictool.adapters.model_polytope import polytope
from frictool.errors import NoSolutionError
from frictool.lmi.hinf_synthesis import minimise
from frictool.plant.linearised_vertices import rates_of
from frictool.plant.polytope import PARAMETERS, PlantPoint
from frictool.synth.lmi_synthesis import pole_region, solve_inequalities
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem, check_claim


def bound(problem: SynthesisProblem) -> float:
    """Return the smallest gamma of the inequalities; inf if the inequalities are infeasible.

    The plants are the vertices and the centre. No controller is computed.
    """
    posed = problem.posed_with_constant_input()
    design = problem.design
    box = polytope(problem.model, design.schedule or PARAMETERS)
    plants = [
        posed.plant(rates_of(point, box.centre, design.vertices))
        for point in (box.centre, *box.vertices)
    ]
    try:
        return minimise(plants, design.recentring, pole_region(design.poles)).optimum
    except (NoSolutionError, np.linalg.LinAlgError):
        return np.inf


def lpv(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the candidate: a controller for the plant `frozen_at`, and one for each vertex.

    Raises NoSolutionError if the inequalities have no solution, or if the norm of a loop exceeds
    the gamma of the inequalities.
    """
    posed = problem.posed_with_constant_input()
    design = problem.design
    box = polytope(problem.model, design.schedule or PARAMETERS)
    frozen = box.centre if design.frozen_at == "centre" else identified_plant(problem)
    plants = [
        posed.plant(rates_of(point, box.centre, design.vertices))
        for point in (frozen, *box.vertices)
    ]
    lyapunov, (k, *corners) = solve_inequalities(problem, plants)
    check_claim(k, plants[0], lyapunov.gamma, f"the {design.frozen_at} plant")
    for point, plant, corner in zip(box.vertices, plants[1:], corners, strict=True):
        check_claim(
            corner, plant, lyapunov.gamma, f"vertex {point.name} with the controller of this vertex"
        )
    return problem.candidate(k, lyapunov.gamma, lyapunov.optimum, scheduled=corners, over=box)


def identified_plant(problem: SynthesisProblem) -> PlantPoint:
    """Return the plant with the model's estimated values of the parameters."""
    today = problem.model.parameters
    constant = problem.model.bench.actuator.constant
    return PlantPoint(
        "identified", today.inertia.value, today.viscous.value, today.coulomb.value, constant.value
    )
