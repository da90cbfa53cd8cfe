"""Method `auto`: a search by play, which a caller above this package conducts.

`campaign/automatic_design.py` searches a design with another method, which is then synthesised.
"""

from __future__ import annotations

from frictool.errors import NoSolutionError
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def auto(problem: SynthesisProblem) -> ControllerCandidate:
    """Raise NoSolutionError: this method solves no problem by itself."""
    raise NoSolutionError(
        f"{problem.design.name}: method auto searches a design by play, as frictool synth does; "
        "synthesise the design that it finds"
    )
