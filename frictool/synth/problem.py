"""What a method of synthesis is given, and what it has to return. A method is a function from one to the other, in a file of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plant.generalised import Controlled, GeneralisedPlant, Uncertainty, Weights, generalised_plant
from frictool.plant.linear_axis import Rates
from frictool.plant.lti import Lti, tustin
from frictool.plant.polytope import Polytope
from frictool.verify.speed_loop import performance

CLAIM = 1.01  # a norm may exceed what is claimed by 1 %


@dataclass(frozen=True)
class Problem:
    """The plants, the weights and the options of one design; `period` [s] and `delay` [samples] are the bench's, `lag` [s] the drive's."""

    box: Polytope
    lag: float
    period: float
    delay: int
    weights: Weights
    design: Design
    model: Model
    spec: Spec

    @property
    def controlled(self) -> Controlled:
        return "position" if self.design.structure == "position" else "speed"

    @property
    def sampled(self) -> bool:
        """Whether the design is made at the bench's period, and not in continuous time."""
        return self.design.domain == "discrete"

    def plant(self, rates: Rates, uncertainty: Uncertainty | None = None) -> GeneralisedPlant:
        """In the design's domain; sampled, with the bench's delay inside."""
        if not self.sampled:
            return generalised_plant(self.controlled, rates, self.lag, self.weights, uncertainty=uncertainty)
        return generalised_plant(self.controlled, rates, self.lag, self.weights, self.period, self.delay, uncertainty)

    def running(self, rates: Rates) -> GeneralisedPlant:
        """Sampled at the bench's period with its delay, without an uncertainty channel: what is verified."""
        return generalised_plant(self.controlled, rates, self.lag, self.weights, self.period, self.delay)

    def discretised(self, k: Lti) -> Lti:
        """A controller found in continuous time as it will run; one found at the period as it is."""
        return k if k.period else tustin(k, self.period, self.design.prewarp_rad_s or 0.0)


@dataclass(frozen=True)
class Candidate:
    """A controller that is not verified yet.

    controller: at the bench's period. designed: as found, in the design's domain. gamma: the bound asked of the method's own plants, None
    where the method has none; optimum: the smallest one found. notes: for people. scheduled: one controller a vertex in common
    coordinates (5.64).
    """

    controller: Lti
    designed: Lti
    gamma: float | None = None
    optimum: float | None = None
    notes: tuple[str, ...] = ()
    scheduled: tuple[Lti, ...] = ()


def claim(k: Lti, plant: GeneralisedPlant, gamma: float, where: str) -> float:
    """The true norm of the loop of a method's own plant. Raises NoSolutionError where it is above `gamma` by more than 1 %."""
    norm = performance(k, plant)
    if not norm <= CLAIM * gamma:
        found = "the loop is unstable" if np.isinf(norm) else f"its norm is {norm:.4g}"
        raise NoSolutionError(
            f"not verified: the inequalities claim gamma {gamma:.4g} at {where}, but {found}; raise `recentring`, or bring the weights "
            "nearer to each other"
        )
    return norm
