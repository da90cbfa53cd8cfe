"""Load of the model, treated as a bounded disturbance that the drive must balance.

    offset     constant
    gravity    s sin x + c cos x at the position x, at most its amplitude
    ripple     s sin x + c cos x at the phase x of the ripple, at most its amplitude

s and c are coefficients of the model, which are known within intervals.

The plants of the polytope do not contain the load. A spring raises an error, because the loop is
not designed for its stiffness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.errors import NoSolutionError


@dataclass(frozen=True)
class LoadDisturbance:
    """Largest load terms, and the efforts that can hold the load [N m | N].

    - offset, gravity, ripple: largest absolute value of each load term
    - available: effort of the actuator at its limit
    - breakaway: lower end of the interval of the breakaway friction
    """

    offset: float
    gravity: float
    ripple: float
    available: float
    breakaway: float

    @property
    def total(self) -> float:
        """Return the sum of offset, gravity and ripple."""
        return self.offset + self.gravity + self.ripple


def disturbance(model: Model) -> LoadDisturbance:
    """Return the largest load terms within the intervals of the model.

    Raises NoSolutionError if the load has a spring, or if the sum of load and Coulomb friction may
    exceed the actuator's effort.
    """
    load = model.laws.load if model.laws else None
    today = model.parameters
    actuator = model.bench.actuator
    gravity = ripple = 0.0
    if load is not None:
        if load.stiffness is not None:
            spring = load.stiffness
            unit = load.stiffness.unit
            raise NoSolutionError(
                f"laws.load.stiffness is {spring.value:.4g} {unit}: the design needs an axis "
                "without a spring; remove the spring from the axis or, if its effort is "
                "negligible, delete this key"
            ).at("model", "laws.load.stiffness")
        gravity = 0.0 if load.gravity is None else amplitude(load.gravity.sine, load.gravity.cosine)
        ripple = sum(amplitude(one.sine, one.cosine) for one in load.ripples)
    offset = largest(today.offset)
    available = actuator.constant.interval[0] * actuator.limit.value
    estimate = LoadDisturbance(offset, gravity, ripple, available, today.breakaway.interval[0])
    friction = largest(today.coulomb)
    if estimate.total + friction >= available:
        raise NoSolutionError(
            f"the load ({estimate.total:.4g}) and Coulomb friction ({friction:.4g}) can exceed "
            f"the actuator's {available:.4g} {today.offset.unit}; "
            "narrow the intervals of load and coulomb, or raise actuator.limit"
        ).at("model", "parameters.coulomb")
    return estimate


def largest(estimate: Estimate) -> float:
    """Return the largest absolute value of the estimate's interval."""
    return max(map(abs, estimate.interval))


def amplitude(sine: Estimate, cosine: Estimate) -> float:
    """Return the maximum of |s sin x + c cos x| over all x, and all s and c in their intervals.

    The interval of s is that of `sine`, the interval of c that of `cosine`.
    """
    return math.hypot(largest(sine), largest(cosine))
