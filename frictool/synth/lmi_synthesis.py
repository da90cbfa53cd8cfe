"""Common steps of the synthesis methods by matrix inequalities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictool.documents.design import Poles
from frictool.errors import FrictoolError, NoSolutionError
from frictool.lmi.hinf_synthesis import LyapunovPair, minimise, vertex_controllers
from frictool.lmi.pole_regions import PoleDisc, PoleHalfPlane, PoleRegion
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.synth.synthesis_problem import SynthesisProblem

# (pole of W2 [rad/s]) times the sample period
SLOW = 5e-5  # below this value, the pole is nearly an integrator
EASY = 1e-4  # above this value, the inequalities are well-conditioned


def solve_inequalities(
    problem: SynthesisProblem, plants: Sequence[GeneralisedPlant]
) -> tuple[LyapunovPair, tuple[Lti, ...]]:
    """Return the Lyapunov matrices common to all plants, and the controller of each plant.

    The gamma of the result is the bound of the norm that the controllers guarantee: the factor
    `ease` of the design times the gamma of the inequalities. All controllers have the same state
    coordinates. Raises NoSolutionError if there is no solution or the arithmetic fails,
    FrictoolError if the pole region is impossible.
    """
    try:
        region = pole_region(problem.design.poles)
        lyapunov = minimise(plants, problem.design.recentring, region)
        ease = problem.design.ease
        return replace(lyapunov, gamma=ease * lyapunov.gamma), vertex_controllers(
            plants, lyapunov, ease
        )
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(
            f"the synthesis broke down numerically ({error}); reduce the ratio of the "
            "largest to the smallest weight"
        ) from None
    except ValueError as error:
        raise FrictoolError(f"{problem.design.name}: {error}") from None
    except NoSolutionError as error:
        raise NoSolutionError(f"{error}{slow_weight(problem)}") from None


def slow_weight(problem: SynthesisProblem) -> str:
    """Return advice for an error message if the pole of the weight W2 is nearly an integrator.

    No controller can move this pole, so that the inequalities may have no solution. The result is
    empty if the pole is fast enough for a solution.
    """
    weight = problem.weights.error
    share = weight.pole * problem.period
    if share >= SLOW:
        return ""
    return (
        f"; W2 for a static error of {1.0 / weight.gain:.2g} has a pole at {weight.pole:.2g} "
        f"rad/s, which is nearly an integrator at the sample period of {problem.period:g} s; no "
        f"controller moves this pole: try weights.static_error {EASY / share / weight.gain:.1g}"
    )


def pole_region(poles: Poles | None) -> PoleRegion | None:
    """Return the region for the closed-loop poles; None if the design requests no region."""
    if poles is None:
        return None
    if poles.decay_rad_s is not None:
        return PoleHalfPlane(poles.decay_rad_s)
    return PoleDisc(poles.centre or 0.0, poles.radius or 0.0)
