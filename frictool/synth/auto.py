"""Method `auto`: placeholder for a search by simulation (campaign/automatic_design.py).

The search returns a design with a method other than `auto`; this design is then synthesised.
"""

from __future__ import annotations

from frictool.errors import NoSolutionError
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def auto(problem: SynthesisProblem) -> ControllerCandidate:
    """Raise NoSolutionError: the search must replace the method `auto` before a synthesis."""
    raise NoSolutionError(
        f"{problem.design.name}: method auto searches for a design by simulation, which only the "
        "command frictool synth does; run it, or write another method"
    )
