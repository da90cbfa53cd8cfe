"""Check of the loops of an axis with a spring, at every vertex and for the extreme stiffnesses.

The plants of a design and of its certificate have no spring. The spring adds the effort stiffness
times position to the equation of motion. This term is linear, so that the check includes the spring
without approximation. Each loop is checked without and with the resonances of the model.

A loop that feeds back the speed only, with an integrator, holds the axis at any position against
the spring. Each position is then an equilibrium, and the loop has one pole at z = 1. The input of
the sensitivity function does not excite the mode of this pole. The mode is removed before the
check, because its pole would count as unstable.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.adapters.resonance_filter import resonance_filters
from frictool.documents.quantity import Estimate
from frictool.documents.resonances import Resonances
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import smallest
from frictool.verify.feedback_loops import FeedbackLoop, open_loop
from frictool.verify.hinf_norm import norm, spectral_radius
from frictool.verify.margins import sensitivity

SINGULAR = 1e-11  # relative size of a singular value of a - 1 that is treated as 0
UNREACHED = 1e-9  # relative size of an input that does not excite a mode


@dataclass(frozen=True)
class SpringCheck:
    """Worst spectral radius and modulus margin of all loops, vertices and extreme stiffnesses.

    `where` names loop, vertex and stiffness of the worst case. This is the case with the smallest
    margin or, if a loop is unstable, the case with the largest spectral radius.
    """

    spectral_radius: float
    modulus_margin: float
    where: str


def spring_check(
    loops: Sequence[FeedbackLoop],
    points: Sequence[PlantPoint],
    axis: tuple[float, int],
    stiffness: Estimate,
    resonances: Resonances | None,
) -> SpringCheck | None:
    """Return the worst spectral radius and margin of all loops, plants and extreme stiffnesses.

    - axis: time constant of the drive [s], and computational delay [samples]
    - stiffness: stiffness of the spring [N m/rad | N/m] with its interval

    An unstable loop has the margin 0. The result is None if both ends of the interval are 0.
    """
    lag, delay_samples = axis
    filters = (None,) if resonances is None else (None, *resonance_filters(resonances))
    ends = [end for end in dict.fromkeys(stiffness.interval) if end != 0.0]
    radii, margins, places = [], [], []
    for loop, point, end, resonance in itertools.product(loops, points, ends, filters):
        rates = replace(point.rates, spring=end / point.inertia)
        closed = _excited(sensitivity(open_loop(loop, rates, lag, delay_samples, resonance)))
        radii.append(spectral_radius(closed.a))
        margins.append(1.0 / norm(closed)[0] if radii[-1] < 1.0 else 0.0)
        places.append(f"{loop.name} at vertex {point.name}, {end:.4g} {stiffness.unit}")
    if not radii:
        return None
    radius = max(radii)
    margin, at = smallest(margins)
    return SpringCheck(radius, margin, places[radii.index(radius) if radius >= 1.0 else at])


def require_spring_margin(check: SpringCheck | None, required: float, name: str = "") -> None:
    """Raise NoSolutionError if a loop with a spring is unstable or has too small a margin.

    name: name of the controller at the start of the message; "" for a message without a name.
    Without a spring, `check` is None and nothing is raised.
    """
    if check is None:
        return
    before = f"{name}: not verified: " if name else "not verified: "
    remedy = "lower the gain of the loop, or weaken the spring"
    if check.spectral_radius >= 1.0:
        raise NoSolutionError(
            f"{before}with the spring, {check.where}: the loop is unstable "
            f"(spectral radius {check.spectral_radius:.6g}); {remedy}"
        )
    if check.modulus_margin < required:
        raise NoSolutionError(
            f"{before}with the spring, {check.where}: the modulus margin is "
            f"{check.modulus_margin:.4g}, below the specified {required:g}; {remedy}"
        )


def _excited(closed: Lti) -> Lti:
    """Return the system without a mode at z = 1, if the input does not excite this mode."""
    left, sizes, _ = np.linalg.svd(closed.a - np.eye(closed.order))
    mode = left[:, -1]
    reached = float(np.max(np.abs(mode @ closed.b)))
    singular = sizes[-1] <= SINGULAR * sizes[0]
    if not singular or reached > UNREACHED * float(np.max(np.abs(closed.b))):
        return closed
    # the states x with mode x = 0 are invariant and contain every state that the input reaches
    rest = left[:, :-1]
    return replace(closed, a=rest.T @ closed.a @ rest, b=rest.T @ closed.b, c=closed.c @ rest)
