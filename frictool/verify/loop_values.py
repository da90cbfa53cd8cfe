"""Values of a controller's linear loops: norms, margins, drive per encoder count, rounding.

`synth` stores these values under `verified`; `verify` computes them again with this module.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.adapters.state_space import read_state_space
from frictool.documents import controller as stored
from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.design import Domain, Structure
from frictool.plant.generalised_plant import (
    Controlled,
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
)
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PlantPoint
from frictool.verify.coefficient_rounding import coefficient_rounder, rounded_linear
from frictool.verify.document_check import loop_checks
from frictool.verify.encoder_count_drive import drive_after_count
from frictool.verify.feedback_loops import (
    FeedbackLoop,
    feedbacks,
    friction_to_speed,
    from_position,
    open_loop,
    running_form,
)
from frictool.verify.hinf_norm import norm
from frictool.verify.interior_search import worst_inside, worst_sensitivity
from frictool.verify.margins import loop_margins
from frictool.verify.speed_loop import is_required, performance
from frictool.verify.stored_forms import limited_radius

CLAIM = 1.01  # largest allowed ratio of a norm to the norm at the vertices
# formats in which every controller is verified
HELD: tuple[stored.Number, ...] = ("double", "float")
# formats that the document lists only if the loop tolerates them; export refuses unlisted formats
OFFERED: tuple[stored.Number, ...] = ("q31", "q15")


@dataclass(frozen=True)
class LinearLoops:
    """Linear loops of a controller at the vertices `points`, with the data for norms and margins.

    - weights: weights of the norm; None if the largest sensitivity replaces the weighted norm
    - period: sample period [s]
    - lag: time constant of the drive [s]
    - delay: computational delay [samples]
    - count: size of an encoder count [rad | m]
    """

    structure: Structure
    domain: Domain
    linear: stored.LinearController
    position_law: stored.PositionLaw | None
    velocity: stored.Velocity
    weights: PlantWeights | None
    points: tuple[PlantPoint, ...]
    period: float
    delay: int
    lag: float
    count: float

    def feedbacks(self, number: stored.Number = "double") -> tuple[FeedbackLoop, ...]:
        """Return the loops with their coefficients rounded to a number format."""
        linear = self.linear if number == "double" else rounded_linear(self.linear, number)
        return feedbacks(
            self.structure,
            linear,
            self.position_law,
            self.velocity,
            self.period,
            coefficient_rounder(number),
        )

    def plant(self, rates: AxisRates, *, sampled: bool = True) -> GeneralisedPlant:
        """Return the weighted plant of an axis; `rates`: parameters divided by the inertia.

        sampled: True for a sampled plant with the computational delay, False for a continuous
        plant without delay. `weights` must not be None.
        """
        assert self.weights is not None
        controlled: Controlled = "position" if self.structure == "position" else "speed"
        if not sampled:
            return generalised_plant(controlled, rates, self.lag, self.weights)
        return generalised_plant(controlled, rates, self.lag, self.weights, self.period, self.delay)

    def vertex(self, point: PlantPoint) -> stored.Vertex:
        """Return parameters, norms, modulus margin and stability at one vertex.

        If a loop is unstable, the norm is infinite and `stable` is false.
        """
        checks = loop_checks(self.feedbacks(), point, self.lag, delays_checked(self.delay))
        margin = next(check.modulus_margin for check in checks if check.delay_samples == self.delay)
        sampled_norm = designed_norm = self._norm(self.linear, point, margin)
        if self.domain == "continuous" and self.weights is not None:
            designed_norm = performance(
                read_state_space(self.linear.continuous, 0.0),
                self.plant(point.rates, sampled=False),
            )
        return stored.Vertex(
            name=point.name,
            inertia=point.inertia,
            viscous=point.viscous,
            coulomb=point.coulomb,
            constant=point.constant,
            norm=designed_norm,
            sampled_norm=sampled_norm,
            modulus_margin=margin,
            stable=all(
                check.spectral_radius < 1.0
                for check in checks
                if is_required(check.delay_samples, self.delay)
            )
            and math.isfinite(sampled_norm),
            checks=checks,
        )

    def count_drive(self) -> float:
        """Return the largest drive [A | V] that one encoder count causes at rest."""
        return max(drive_after_count(from_position(loop), self.count) for loop in self.feedbacks())

    def margins(self) -> stored.Margins:
        """Return the worst value of each margin over all loops and vertices."""
        loops = self.feedbacks()
        margins_of_loops = [
            loop_margins(open_loop(loop, point.rates, self.lag, self.delay))
            for loop in loops
            for point in self.points
        ]
        friction = max(
            norm(friction_to_speed(loops[-1], point.rates, self.lag, self.delay))[0]
            for point in self.points
        )
        return stored.Margins(
            gain_increase=_finite(min(one.gain_up for one in margins_of_loops)),
            gain_decrease=max(one.gain_down for one in margins_of_loops) or None,
            phase_deg=float(np.degrees(min(one.phase for one in margins_of_loops))),
            delay_s=_finite(min(one.delay for one in margins_of_loops)),
            small_gain=friction,
        )

    def rounded(self, number: stored.Number) -> stored.Rounded:
        """Return the worst norm and modulus margin with coefficients rounded to a number format.

        If rounding makes the anti-windup unstable, the margin is 0 and the norm infinite.
        """
        linear = rounded_linear(self.linear, number)
        if limited_radius(linear, self.period) >= 1.0:
            return stored.Rounded(number, math.inf, 0.0)
        loops = self.feedbacks(number)
        margins = [
            loop_checks(loops, point, self.lag, (self.delay,))[0].modulus_margin
            for point in self.points
        ]
        gamma = max(
            self._norm(linear, point, margin)
            for point, margin in zip(self.points, margins, strict=True)
        )
        return stored.Rounded(number, gamma, min(margins))

    def seen_inside(self) -> float:
        """Return the largest norm at the vertices and at the plants of a search between them.

        The search is local. If `weights` is None, the largest sensitivity replaces the norm, and
        only scattered plants are evaluated.
        """
        loops = self.feedbacks()
        if self.weights is not None:
            return worst_inside(loops[0].system, self.plant, self.points)[1].norm
        at_vertices, inside, _ = worst_sensitivity(loops, self.lag, self.delay, self.points)
        return max(at_vertices, inside)

    def _norm(self, linear: stored.LinearController, point: PlantPoint, margin: float) -> float:
        if self.weights is not None:
            return performance(running_form(linear, self.period), self.plant(point.rates))
        return 1.0 / margin if margin > 0.0 else math.inf


def delays_checked(delay: int) -> tuple[int, ...]:
    """Return the delays at which every loop is checked [samples]: 0, 1 and `delay`."""
    return tuple(sorted({0, 1, delay}))


def tolerates_rounding(rounded: stored.Rounded, claimed: float, required: float) -> bool:
    """Return True if rounding raises the norm by at most 1 % and leaves the required margin.

    - rounded: norm and margin with rounded coefficients
    - claimed: norm before rounding
    - required: required modulus margin
    """
    return (
        rounded.gamma <= CLAIM * claimed
        and rounded.modulus_margin >= required
        and math.isfinite(rounded.gamma)
    )


def loops_of(controller: stored.Controller, points: tuple[PlantPoint, ...]) -> LinearLoops:
    """Return the linear loops of a controller document at the vertices `points`."""
    weights = controller.judged_by
    return LinearLoops(
        structure=controller.structure,
        domain=controller.domain,
        linear=controller.linear,
        position_law=controller.position_law,
        velocity=controller.velocity,
        weights=None if weights is None else weights_of(weights),
        points=points,
        period=controller.sample_period_s,
        delay=controller.delay_samples,
        lag=controller.bench.actuator.loop_time_constant_s,
        count=controller.bench.encoder.resolution,
    )


def weights_of(document: CertifiedWeights) -> PlantWeights:
    """Return the weights stored in a document, as weights of a generalised plant."""
    error, noise = first_order(document.error), first_order(document.noise)
    return PlantWeights(
        error, document.disturbance, document.drive, document.command, noise, document.eta
    )


def first_order(document: Filter) -> FirstOrderWeight:
    """Return a stored first-order filter as a weight; a missing corner frequency means infinity."""
    return FirstOrderWeight(
        document.gain,
        *(math.inf if value is None else value for value in (document.zero, document.pole)),
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
