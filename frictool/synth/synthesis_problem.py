"""Problem that a synthesis method solves, and the controller candidate that it returns.

A method is a function from `SynthesisProblem` to `ControllerCandidate`, in a separate file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.documents.synthesis_methods import METHODS, SynthesisMethod
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import (
    Controlled,
    GeneralisedPlant,
    PlantWeights,
    UncertaintyChannel,
    generalised_plant,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti, tustin
from frictool.plant.polytope import Polytope
from frictool.synth.order_reduction import reduce_order
from frictool.synth.slow_pole import stabilise_slow_pole, with_integrator
from frictool.verify.loop_values import CLAIM
from frictool.verify.speed_loop import check_loop, performance


@dataclass(frozen=True)
class SynthesisProblem:
    """Plants, weights and options of one design.

    - period: sample period in bench.yaml [s]
    - delay: delay in bench.yaml [samples]
    - lag: time constant of the drive [s]
    - box: interval of each parameter; the controller is verified for all constant plants within
      these intervals
    """

    box: Polytope
    lag: float
    period: float
    delay: int
    weights: PlantWeights
    design: Design
    model: Model
    spec: Spec
    progress: Callable[[str], None] = lambda _: (
        None
    )  # called with the current step of a slow method

    @property
    def controlled(self) -> Controlled:
        """Return the quantity that the linear controller controls, position or speed."""
        return "position" if self.design.structure == "position" else "speed"

    @property
    def weighs(self) -> bool:
        """Return True if the design bounds a weighted norm, False if it bounds the sensitivity.

        The sensitivity is bounded if the input of the controller is the speed error.
        """
        return not self.design.speed_input

    @property
    def method(self) -> SynthesisMethod:
        """Return the description of the design's synthesis method."""
        return METHODS[self.design.method]

    @property
    def sampled(self) -> bool:
        """Return True if the design is in discrete time, at the sample period in bench.yaml."""
        return self.design.domain == "discrete"

    def plant(
        self, rates: AxisRates, uncertainty: UncertaintyChannel | None = None
    ) -> GeneralisedPlant:
        """Return the weighted plant in continuous or discrete time, as the design requests.

        A plant in discrete time includes the delay in bench.yaml.
        """
        if not self.sampled:
            return generalised_plant(
                self.controlled, rates, self.lag, self.weights, uncertainty=uncertainty
            )
        return generalised_plant(
            self.controlled, rates, self.lag, self.weights, self.period, self.delay, uncertainty
        )

    def running(self, rates: AxisRates) -> GeneralisedPlant:
        """Return the weighted plant for the verification, sampled at the period in bench.yaml.

        The plant includes the delay in bench.yaml, and has no uncertainty channel.
        """
        return generalised_plant(
            self.controlled, rates, self.lag, self.weights, self.period, self.delay
        )

    @property
    def bandwidth(self) -> float:
        """Return the bandwidth z2 of the error weight W2 [rad/s]."""
        return self.weights.error.zero

    def posed_with_constant_input(self) -> SynthesisProblem:
        """Return a problem in which all plants have the same input matrix B2.

        The inequalities of several plants require a common B2 (thesis 5.61). B2 is common if the
        command acts through the drive's lag or through a delay register. A sampled plant without
        delay therefore gets a delay register, which later becomes part of the controller
        (`with_register`). Raises NoSolutionError for a design in continuous time if the drive has
        no lag.
        """
        if self.sampled:
            return replace(self, delay=max(self.delay, 1))
        if self.lag == 0.0:
            raise NoSolutionError(
                f"method {self.design.method} in continuous time needs a drive with a time "
                "constant (actuator.loop_time_constant_s is 0): "
                "the vertices would have different input matrices; write `domain: discrete`"
            )
        return self

    def candidate(
        self,
        k: Lti,
        gamma: float,
        optimum: float,
        notes: Sequence[str] = (),
        scheduled: Sequence[Lti] = (),
        over: Polytope | None = None,
    ) -> ControllerCandidate:
        """Return the candidate for a controller `k` designed with `posed_with_constant_input`.

        If necessary, the slowest pole of `k` is replaced by an integrator or by a stable pole. The
        order is reduced if the design requests a lower order.
        """
        remarks = list(notes)
        moved = (
            with_integrator(k, self.bandwidth)
            if self.design.integrator
            else stabilise_slow_pole(k, self.bandwidth, self.weights.error.pole)
        )
        if moved is not k:
            remarks.append(
                "the slowest pole of the controller was moved "
                + ("to an integrator" if self.design.integrator else "into the stable region")
            )
        kept = self._reduced(moved)
        if kept is not moved:
            remarks.append(
                f"the controller was reduced from order {moved.order} to {kept.order}, each step "
                "verified"
            )
        corners = tuple(scheduled)
        if self.sampled and self.delay == 0:
            kept = with_register(kept)
            corners = tuple(with_register(corner) for corner in corners)
        sampled = tuple(self.discretised(corner) for corner in corners)
        return ControllerCandidate(
            self.discretised(kept), kept, gamma, optimum, tuple(remarks), sampled, over
        )

    def _reduced(self, k: Lti) -> Lti:
        order = self.design.order
        return (
            k
            if order is None or order >= k.order
            else reduce_order(k, order, self.check)[-1].controller
        )

    def check(self, k: Lti) -> None:
        """Raise NoSolutionError if a sampled loop is unstable or has too small a modulus margin.

        Each loop consists of the controller `k` (continuous or discrete time) and one vertex plant.
        The specification states the required margin.
        """
        running = self.discretised(k)
        required = self.spec.modulus_margin or 0.0
        for point in self.box.vertices:
            loop_check = check_loop(running, point.rates, self.lag, self.delay)
            if not loop_check.stable or loop_check.modulus_margin < required:
                raise NoSolutionError(
                    f"not verified: modulus margin {loop_check.modulus_margin:.3f} at vertex "
                    f"{point.name} is below the specified {required:g}; raise order"
                )

    def discretised(self, k: Lti) -> Lti:
        """Return `k` discretised by Tustin's method; a sampled `k` is returned unchanged.

        bench.yaml states the sample period.
        """
        return k if k.period else tustin(k, self.period, self.design.prewarp_rad_s or 0.0)


@dataclass(frozen=True)
class ControllerCandidate:
    """Controller that a synthesis method returns, before its verification.

    - controller: the controller, sampled at the sample period in bench.yaml
    - designed: the controller in the time domain of the design, before it was sampled
    - gamma: bound of the norm that the method guarantees for its plants; None if there is no such
      bound
    - optimum: smallest gamma of the inequalities, or smallest worst norm of method `minimax`; else
      None
    - scheduled: one controller at the sample period in bench.yaml for each vertex of the polytope
      `over`, with common state coordinates (thesis 5.64)
    """

    controller: Lti
    designed: Lti
    gamma: float | None = None
    optimum: float | None = None
    notes: tuple[str, ...] = ()
    scheduled: tuple[Lti, ...] = ()
    over: Polytope | None = None


def check_claim(k: Lti, plant: GeneralisedPlant, gamma: float, where: str) -> float:
    """Return the computed norm of the loop of controller `k` and `plant`.

    Raises NoSolutionError if the norm exceeds `gamma`, the bound of the inequalities, by more than
    1 %.
    """
    norm = performance(k, plant)
    if not norm <= CLAIM * gamma:
        finding = "the loop is unstable" if np.isinf(norm) else f"its norm is {norm:.4g}"
        raise NoSolutionError(
            f"not verified: the inequalities claim gamma {gamma:.4g} at {where}, but {finding}; "
            "raise `recentring`, or reduce the ratio of the largest to the smallest weight"
        )
    return norm


def with_register(k: Lti) -> Lti:
    """Return the controller `k` with one sample of delay at its output."""
    n = k.order
    a = np.block([[k.a, np.zeros((n, 1))], [k.c, np.zeros((1, 1))]])
    return Lti(a, np.vstack([k.b, k.d]), np.eye(n + 1)[n:], np.zeros((1, 1)), k.period)
