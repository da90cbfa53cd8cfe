"""Method `lpv`: the polytope's vertices with common Lyapunov matrices (theorem 5.3.1), the controller frozen at one plant (5.3.4).

The frozen controller is not covered by the inequalities at the vertices: it is accepted only after the sampled loop, rebuilt from the
stored coefficients, was verified there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.errors import NoSolutionError
from frictool.lmi.discrete_hinf import controller, minimise
from frictool.plant.lti import Lti
from frictool.synth.problem import Candidate, Problem, claim


def lpv(problem: Problem) -> Candidate:
    """Raises NoSolutionError where the inequalities have no solution, or the solution does not hold what they claim."""
    bare = problem.sampled and problem.delay == 0
    # The command must enter every vertex alike (B2 constant, 5.61): through the drive's lag, or through a register of delay. A sampled
    # plant without delay gets the register inside its controller, whose output then depends on the samples before only.
    posed = replace(problem, delay=1) if bare else problem
    if not problem.sampled and problem.lag == 0.0:
        raise NoSolutionError(
            "method lpv in continuous time needs a drive with a time constant (actuator.loop_time_constant_s is 0): the command would "
            "enter every vertex differently; take domain: discrete"
        )
    plants = [posed.plant(point.rates) for point in (problem.box.centre, *problem.box.vertices)]
    try:
        lyapunov = minimise(plants, problem.design.recentring)
        k = controller(plants[0], lyapunov)
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(f"the synthesis broke down numerically ({error}); bring the weights nearer to each other") from None
    claim(k, plants[0], lyapunov.gamma, "the centre")
    designed = with_register(k) if bare else k
    return Candidate(problem.discretised(designed), designed, lyapunov.gamma, lyapunov.optimum)


def with_register(k: Lti) -> Lti:
    """The controller followed by one sample of delay."""
    n = k.order
    a = np.block([[k.a, np.zeros((n, 1))], [k.c, np.zeros((1, 1))]])
    return Lti(a, np.vstack([k.b, k.d]), np.eye(n + 1)[n:], np.zeros((1, 1)), k.period)
