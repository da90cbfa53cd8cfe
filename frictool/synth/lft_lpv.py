"""Method `lft_lpv`: polytope of the scheduled parameters, uncertainty channel for all others.

Each vertex of the polytope has a separate uncertainty channel (annex C of the thesis, (28)-(32)).
If the design names no scheduled parameters, the friction regimes are scheduled, as in the annex.
The target hardware runs the controller of the plant in the middle of the vertices. In the example
of section 5.2 of the annex, the two vertex controllers agree at low frequencies.
"""

from __future__ import annotations

from frictool.adapters.model_polytope import uncertain_polytope, unscheduled_half_widths
from frictool.plant.uncertainty_channel import with_channel
from frictool.synth.lmi_synthesis import solve_inequalities
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem, check_claim


def lft_lpv(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the candidate with the controllers of the centre plant and of the vertices.

    Raises NoSolutionError if the inequalities have no solution, or if the norm of a loop exceeds
    the gamma of the inequalities.
    """
    posed = problem.posed_with_constant_input()
    design = problem.design
    scheduled_names = design.schedule or ("regime",)
    box, corners = uncertain_polytope(problem.model, scheduled_names, design.channel_effort)
    centre = with_channel(
        box.centre, unscheduled_half_widths(problem.model, scheduled_names), corners[0].unit
    )
    plants = [posed.plant(one.rates, one.uncertainty) for one in (centre, *corners)]
    lyapunov, (k, *scheduled) = solve_inequalities(problem, plants)
    for one, plant, controller in zip((centre, *corners), plants, (k, *scheduled), strict=True):
        check_claim(
            controller, plant, lyapunov.gamma, f"{one.point.name} with its uncertainty channel"
        )
    return problem.candidate(k, lyapunov.gamma, lyapunov.optimum, scheduled=scheduled, over=box)
