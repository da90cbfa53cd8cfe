"""Method `lft`: one plant, the centre, whose uncertain parameters are a real channel with |Delta| <
1, annex (20)-(23), figure 5.

gamma <= 1 on the whole, channel included, is what the small-gain theorem asks for the parameters
moving together (plant/uncertainty_channel.py); what runs is verified at every corner of their box.
"""

from __future__ import annotations

from frictool.plant.uncertainty_channel import uncertain_centre
from frictool.synth.lmi_synthesis import solve_inequalities
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem, check_claim


def lft(problem: SynthesisProblem) -> ControllerCandidate:
    """Raises NoSolutionError where the inequalities have no solution, or the solution does not hold
    what they claim."""
    posed = problem.posed_with_constant_input()
    centre = uncertain_centre(problem.model, problem.design.channel_effort)
    plant = posed.plant(centre.rates, centre.uncertainty)
    lyapunov, (k,) = solve_inequalities(problem, [plant])
    check_claim(k, plant, lyapunov.gamma, "the centre with its uncertainty channel")
    return problem.candidate(k, lyapunov.gamma, lyapunov.optimum)
