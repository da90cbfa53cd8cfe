"""What the model's load asks of the drive, as the design sees it: a bounded disturbance, which the
plants of the polytope do not hold.

    offset      constant
    gravity     |sine sin x + cosine cos x| <= its amplitude, wherever the axis is
    ripple      likewise

A spring is none: it gives the plant a stiffness, for which this loop is not designed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.errors import NoSolutionError


@dataclass(frozen=True)
class LoadDisturbance:
    """The largest of each, of all together, and what the actuator gives at its limit, N m | N;
    breakaway: the least that holds the axis."""

    offset: float
    gravity: float
    ripple: float
    available: float
    breakaway: float

    @property
    def total(self) -> float:
        return self.offset + self.gravity + self.ripple


def disturbance(model: Model) -> LoadDisturbance:
    """Over the whole of the model's intervals.

    Raises NoSolutionError where the load has a spring, or with the largest friction is more than
    the actuator gives.
    """
    load, today, actuator = (
        model.laws.load if model.laws else None,
        model.parameters,
        model.bench.actuator,
    )
    gravity = ripple = 0.0
    if load is not None:
        if load.stiffness is not None:
            spring, unit = load.stiffness, load.stiffness.unit
            raise NoSolutionError(
                f"laws.load.stiffness is {spring.value:.4g} {unit}: a spring changes the plant, and the speed loop is designed for an axis "
                "without one; take the spring off the axis, or laws.load.stiffness out of the model where it may be neglected"
            ).at("model", "laws.load.stiffness")
        gravity = 0.0 if load.gravity is None else amplitude(load.gravity.sine, load.gravity.cosine)
        ripple = 0.0 if load.ripple is None else amplitude(load.ripple.sine, load.ripple.cosine)
    offset, available = largest(today.offset), actuator.constant.interval[0] * actuator.limit.value
    found = LoadDisturbance(offset, gravity, ripple, available, today.breakaway.interval[0])
    friction = largest(today.coulomb)
    if found.total + friction >= available:
        raise NoSolutionError(
            f"the load of up to {found.total:.4g} and a Coulomb friction of up to {friction:.4g} {today.offset.unit} are more than the "
            f"{available:.4g} {today.offset.unit} that the actuator gives at its limit; narrow the intervals of coulomb and of "
            "actuator.constant, or take a drive with a higher actuator.limit"
        ).at("model", "parameters.coulomb")
    return found


def largest(found: Estimate) -> float:
    """The largest absolute value of its interval."""
    return max(map(abs, found.interval))


def amplitude(sine: Estimate, cosine: Estimate) -> float:
    """The largest of sine sin + cosine cos within the intervals."""
    return math.hypot(largest(sine), largest(cosine))
