"""What every method by matrix inequalities does with its plants: the design's options, and numerical failure as a refusal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictool.documents.design import Poles
from frictool.errors import FrictoolError, NoSolutionError
from frictool.lmi.frames import Disc, HalfPlane, PoleRegion
from frictool.lmi.hinf import Lyapunov, minimise, scheduled
from frictool.plant.generalised import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.synth.problem import Problem


def solved(problem: Problem, plants: Sequence[GeneralisedPlant]) -> tuple[Lyapunov, tuple[Lti, ...]]:
    """The Lyapunov matrices over all plants, with the gamma that is claimed, and the controller of each in common coordinates.

    Raises NoSolutionError where there is none, or the arithmetic breaks down; FrictoolError where the pole region cannot be.
    """
    try:
        region = pole_region(problem.design.poles)
        lyapunov, ease = minimise(plants, problem.design.recentring, region), problem.design.ease
        return replace(lyapunov, gamma=ease * lyapunov.gamma), scheduled(plants, lyapunov, ease)
    except np.linalg.LinAlgError as error:
        raise NoSolutionError(f"the synthesis broke down numerically ({error}); bring the weights nearer to each other") from None
    except ValueError as error:
        raise FrictoolError(f"{problem.design.name}: {error}") from None


def pole_region(poles: Poles | None) -> PoleRegion | None:
    """As the inequalities take it."""
    if poles is None:
        return None
    if poles.decay_rad_s is not None:
        return HalfPlane(poles.decay_rad_s)
    return Disc(poles.centre or 0.0, poles.radius or 0.0)
