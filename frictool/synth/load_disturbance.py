"""Load of the model, treated as a bounded disturbance that the drive must balance.

    offset     constant
    gravity    s sin x + c cos x at the position x, at most its amplitude
    ripple     s sin x + c cos x at the phase x of the ripple, at most its amplitude
    spring     stiffness x + offset at the position x, at most its value at an end of the travel

s, c, stiffness and offset are coefficients of the model, which are known within intervals. The
offset moves the position at which the spring is relaxed, so that spring and offset are bounded
together. If the model states the total load over the travel, the bound of this total limits
the sum.

The plants of the polytope do not contain the load. The loops at their vertices are also verified
with the stiffness of the spring (verify/spring_loop.py).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from frictool.adapters.total_load import valid_total
from frictool.documents.laws import Load
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.errors import NoSolutionError


@dataclass(frozen=True)
class LoadDisturbance:
    """Largest load terms, and the efforts that can hold the load [N m | N].

    - offset, gravity, ripple: largest absolute value of each load term
    - spring: largest absolute value of the sum of spring and offset on the travel; 0 without a
      spring. With a spring, the field `offset` is 0
    - available: effort of the actuator at its limit
    - breakaway: lower end of the interval of the breakaway friction
    - together: largest absolute value of offset and loads together on the travel; None if the model
      does not state it
    """

    offset: float
    gravity: float
    ripple: float
    spring: float
    available: float
    breakaway: float
    together: float | None = None

    @property
    def total(self) -> float:
        """Return the smaller of `together` and the sum of offset, gravity, ripple and spring."""
        terms = self.offset + self.gravity + self.ripple + self.spring
        return terms if self.together is None else min(terms, self.together)


def disturbance(model: Model) -> LoadDisturbance:
    """Return the largest load terms within the intervals of the model.

    Raises NoSolutionError if the sum of load and Coulomb friction may exceed the actuator's effort,
    and for a spring with a negative stiffness or on a bench without a travel.
    """
    load = (model.laws.load if model.laws else None) or Load()
    today = model.parameters
    actuator = model.bench.actuator
    gravity = 0.0 if load.gravity is None else amplitude(load.gravity.sine, load.gravity.cosine)
    ripple = sum(amplitude(one.sine, one.cosine) for one in load.ripples)
    offset, spring = largest(today.offset), 0.0
    if load.stiffness is not None:
        offset, spring = 0.0, _spring_with_offset(load.stiffness, model)
    total = valid_total(model)
    available = actuator.constant.interval[0] * actuator.limit.value
    estimate = LoadDisturbance(
        offset,
        gravity,
        ripple,
        spring,
        available,
        today.breakaway.interval[0],
        None if total is None else max(largest(total.least), largest(total.largest)),
    )
    friction = largest(today.coulomb)
    if estimate.total + friction >= available:
        raise NoSolutionError(
            f"the load ({estimate.total:.4g}) and Coulomb friction ({friction:.4g}) can exceed "
            f"the actuator's {available:.4g} {today.offset.unit}; "
            "narrow the intervals of load and coulomb, or raise actuator.limit"
        ).at("model", "parameters.coulomb")
    return estimate


def stiffness_of(model: Model) -> Estimate | None:
    """Return the stiffness of the model's spring; None if there is no spring."""
    load = model.laws.load if model.laws else None
    return None if load is None else load.stiffness


def _spring_with_offset(stiffness: Estimate, model: Model) -> float:
    """Return the largest absolute value of stiffness x + offset at all positions x of the travel.

    This value occurs at a combination of ends of the intervals of stiffness, offset and position.
    """
    travel = model.bench.mechanics.travel
    named = f"laws.load.stiffness is {stiffness.value:.4g} {stiffness.unit}"
    if stiffness.value < 0.0:
        raise NoSolutionError(
            f"{named}; allowed: >= 0, because a negative stiffness drives the axis away from rest; "
            "balance the axis or, if this effort is negligible, delete this key"
        ).at("model", "laws.load.stiffness")
    if travel is None:
        raise NoSolutionError(
            f"{named}: without a travel, the effort of the spring has no bound; write "
            "mechanics.travel of the bench (low, high), measured from the encoder's zero"
        ).at("model", "laws.load.stiffness")
    corners = itertools.product(
        stiffness.interval, (travel.low, travel.high), model.parameters.offset.interval
    )
    return max(abs(slope * position + offset) for slope, position, offset in corners)


def largest(estimate: Estimate) -> float:
    """Return the largest absolute value in the interval of the estimate."""
    return max(map(abs, estimate.interval))


def amplitude(sine: Estimate, cosine: Estimate) -> float:
    """Return the maximum of |s sin x + c cos x| over all x, and all s and c in their intervals.

    `sine` contains the interval of s, `cosine` the interval of c.
    """
    return math.hypot(largest(sine), largest(cosine))
