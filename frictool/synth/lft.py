"""Method `lft`: H-infinity synthesis for the centre plant with a real uncertainty channel.

The uncertain parameters form a block Delta with |Delta| < 1 around the plant (annex C of the
thesis, (20)-(23), figure 5). If gamma is at most 1 for the plant with this channel, the small-gain
condition holds for all uncertain parameters together (plant/uncertainty_channel.py). The controller
is verified at every corner of the parameter box.
"""

from __future__ import annotations

from frictool.adapters.model_polytope import uncertain_centre
from frictool.synth.lmi_synthesis import solve_inequalities
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem, check_claim


def lft(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the controller candidate for the centre plant with its uncertainty channel.

    Raises NoSolutionError if the inequalities have no solution, or if the norm of the loop exceeds
    the gamma of the inequalities.
    """
    posed = problem.posed_with_constant_input()
    centre = uncertain_centre(problem.model, problem.design.channel_effort)
    plant = posed.plant(centre.rates, centre.uncertainty)
    lyapunov, (k,) = solve_inequalities(problem, [plant])
    check_claim(k, plant, lyapunov.gamma, "the centre with its uncertainty channel")
    return problem.candidate(k, lyapunov.gamma, lyapunov.optimum)
