"""Method `auto`: a search by simulation, which campaign/automatic_design.py conducts.

The search returns a design with another method, which is then synthesised.
"""

from __future__ import annotations

from frictool.errors import NoSolutionError
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def auto(problem: SynthesisProblem) -> ControllerCandidate:
    """Raise NoSolutionError, because a search replaces this method by another one first."""
    raise NoSolutionError(
        f"{problem.design.name}: method auto searches a design by simulation; run frictool synth, "
        "or write another method"
    )
