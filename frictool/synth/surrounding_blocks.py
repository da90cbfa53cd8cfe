"""Blocks around the linear controller, and rules for values that the design leaves out.

    position_law            gain of the square-root law: from friction and inertia of the model
                            band: the encoder's step (thesis 5.7)
    velocity                filter_rad_s: 10 times the prefilter's frequency, thesis (5.70)
    limiter                 inertia and Coulomb friction of the model
                            band delta_e: the encoder's step, the least allowed value (thesis 5.2.2)
                            v_r = 10 F_cv T/J: a viscous brake near standstill, with a time constant
                            of 10 samples
    profile, feedforward    synth/tracking_blocks.py
    friction_compensation   levels of the model, or its friction against speed as a table
                            smoothing_speed: the peak that one encoder count causes in the filtered
                            speed; the design must state it if a sensor measures the speed

Here v_r is `virtual_speed`, F_cv `virtual_coulomb`, T the period and J the inertia. For the mass of
table 5.1, v_r is 0.01 m/s. The thesis (5.2.5) has 10 m/s, which hardly brakes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictool.adapters.slip_curve import coulomb_change, is_plain, signed_friction
from frictool.documents import controller as stored
from frictool.documents.design import Design
from frictool.documents.design_blocks import (
    FrictionCompensationDesign,
    LimiterDesign,
    PositionLawDesign,
)
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import FrictoolError, NoSolutionError
from frictool.synth.tracking_blocks import outside_notes, stored_feedforward, stored_profile
from frictool.synth.weights import DerivedValue
from frictool.verify.encoder_count_drive import drive_after_count
from frictool.verify.feedback_loops import DIFFERENCE, FeedbackLoop, from_position, low_pass

FILTER = 10.0  # times the prefilter's frequency, "10 fois plus rapide" under (5.70)
BRAKE_SAMPLES = 10.0  # samples, time constant of the limiter's brake near standstill
NOT_LINEAR = (
    "nonlinear, so that the loop is verified without it; check the whole loop by frictool simulate"
)


@dataclass(frozen=True)
class SurroundingBlocks:
    """Blocks around the linear controller in their stored form, with derived values and notes."""

    velocity: stored.Velocity
    position_law: stored.PositionLaw | None
    limiter: stored.Limiter | None
    friction_compensation: stored.FrictionCompensation | None
    prefilter: stored.Prefilter | None
    profile: stored.Profile | None
    feedforward: stored.Feedforward | None
    derived: tuple[DerivedValue, ...]
    notes: tuple[str, ...]


def blocks(model: Model, design: Design, drive_peak: float = math.inf) -> SurroundingBlocks:
    """Return the blocks around the linear controller that the design requests.

    drive_peak: largest drive that the specification allows [A | V]. Raises FrictoolError if neither
    the design nor a rule determines a value, NoSolutionError if a block is impossible with this
    model.
    """
    made = _BlockRules(model, design)
    return SurroundingBlocks(
        velocity=made.velocity,
        position_law=made.position_law(),
        limiter=None if design.limiter is None else made.limiter(design.limiter),
        friction_compensation=None
        if design.friction_compensation is None
        else made.compensation(design.friction_compensation),
        prefilter=made.prefilter(),
        profile=None
        if design.profile is None
        else stored_profile(model, design.profile, drive_peak, made.record_derived),
        feedforward=None
        if design.feedforward is None
        else stored_feedforward(model, design.feedforward, made.record_derived),
        derived=tuple(made.derived),
        notes=(*made.notes, *outside_notes(design)),
    )


class _BlockRules:
    def __init__(self, model: Model, design: Design) -> None:
        self.model, self.design = model, design
        self.period = model.bench.sample_period_s
        self.derived: list[DerivedValue] = []
        self.notes: list[str] = []
        self.velocity = self._velocity()

    def record_derived(self, name: str, value: float, unit: str, source: str) -> float:
        self.derived.append(DerivedValue(name, value, unit, source))
        return value

    def unit(self, dimension: str) -> str:
        return si_unit(dimension, self.model.axis)

    def prefilter(self) -> stored.Prefilter | None:
        requested = self.design.prefilter
        return (
            None
            if requested is None
            else stored.Prefilter(requested.natural_frequency_rad_s, requested.damping)
        )

    def position_law(self) -> stored.PositionLaw | None:
        law = self.design.position_law
        if law is None:
            return None
        band = 0.0 if law.band is None else law.band.value
        if law.band is None and (law.kind == "square_root" or law.action != "none"):
            step = self.model.bench.encoder.resolution
            band = self.record_derived(
                "position_law.band", step, self.unit("position"), "the encoder's step"
            )
        return stored.PositionLaw(
            gain=_square_root_gain(self.model, law) if law.gain_per_s is None else law.gain_per_s,
            kind=law.kind,
            formula=law.formula,
            band=band,
            action=law.action,
            settled_speed=None if law.settled_speed is None else law.settled_speed.value,
            rest_speed=0.0 if law.rest_speed is None else law.rest_speed.value,
        )

    def _velocity(self) -> stored.Velocity:
        requested, prefilter = self.design.velocity, self.design.prefilter
        winding = (
            self.model.bench.actuator.winding is not None
        )  # the back-electromotive force of the winding limits the drive
        if not self.design.reads_speed and not winding:
            if requested is not None:
                raise FrictoolError(
                    "velocity: no block of this design reads a speed; remove the key, or add one "
                    "of: `action: brake`, limiter (energy, virtual friction), "
                    "friction_compensation, speed pid, actuator.winding"
                ).at("design", "velocity")
            return stored.Velocity()
        if requested is not None and requested.source == "measured":
            return stored.Velocity(source="measured")
        bandwidth = None if requested is None else requested.filter_rad_s
        if bandwidth is None and prefilter is None:
            raise FrictoolError(
                "velocity.filter_rad_s: missing; the default is 10 times the prefilter's "
                "frequency, but the design has no prefilter; write this key (0: no filter) or a "
                "prefilter"
            ).at("design", "velocity.filter_rad_s")
        if bandwidth is None and prefilter is not None:
            value = FILTER * prefilter.natural_frequency_rad_s
            bandwidth = self.record_derived(
                "velocity.filter_rad_s",
                value,
                "rad/s",
                f"{FILTER:g} times the prefilter's frequency",
            )
        assert bandwidth is not None
        if bandwidth * self.period >= 2.0:
            raise FrictoolError(
                f"velocity.filter_rad_s: found {bandwidth:g}; allowed: below "
                f"{2.0 / self.period:g} rad/s (2/T), or 0 for no filter; a faster filter "
                "alternates from sample to sample"
            ).at("design", "velocity.filter_rad_s")
        order = (requested.order if requested is not None else None) or 2
        return (
            stored.Velocity(order=order, bandwidth_rad_s=bandwidth)
            if bandwidth
            else stored.Velocity()
        )

    def limiter(self, requested: LimiterDesign) -> stored.Limiter:
        today = self.model.parameters
        step = self.model.bench.encoder.resolution
        energy = requested.condition == "energy"
        virtual = 0.0 if requested.virtual_coulomb is None else requested.virtual_coulomb.value
        band = (
            self.record_derived("limiter.band", step, self.unit("position"), "the encoder's step")
            if requested.band is None
            else requested.band.value
        )
        if band < step:
            unit = self.unit("position")
            finding = (
                f"found {band:g} {unit}; allowed: at least the encoder's step, {step:g} {unit}"
            )
            raise FrictoolError(f"limiter.band: {finding}").at("design", "limiter.band")
        if energy and today.coulomb.value + virtual == 0.0:
            raise FrictoolError(
                "limiter: `condition: energy` needs friction, but the model's coulomb is 0; add "
                "`virtual_coulomb`, or write `condition: error`"
            ).at("design", "limiter.condition")
        self.notes.append(
            f"limiter: {NOT_LINEAR}; boundedness and rest are proved, the decrease of a Lyapunov "
            f"function is not"
        )
        return stored.Limiter(
            condition=requested.condition,
            band=band,
            inertia=today.inertia.value if energy else 0.0,
            coulomb=today.coulomb.value if energy else 0.0,
            virtual_coulomb=virtual,
            virtual_speed=self._virtual_speed(requested, virtual),
            settled_speed=None
            if requested.settled_speed is None
            else requested.settled_speed.value,
        )

    def _virtual_speed(self, requested: LimiterDesign, virtual: float) -> float:
        if requested.virtual_speed is not None or virtual == 0.0:
            return 0.0 if requested.virtual_speed is None else requested.virtual_speed.value
        value = BRAKE_SAMPLES * virtual * self.period / self.model.parameters.inertia.value
        return self.record_derived(
            "limiter.virtual_speed",
            value,
            self.unit("velocity"),
            f"{BRAKE_SAMPLES:g} virtual_coulomb T/inertia: {BRAKE_SAMPLES:g} samples",
        )

    def compensation(self, requested: FrictionCompensationDesign) -> stored.FrictionCompensation:
        today = self.model.parameters
        self.notes.append(
            "friction compensation: it uses the reference only, so that it does not change the "
            "margins of the loop"
            if requested.velocity == "reference"
            else f"friction compensation: {NOT_LINEAR}; it is known to cause limit cycles"
        )
        if requested.source == "observer":
            return stored.FrictionCompensation(
                source="observer",
                observer_rad_s=requested.observer_rad_s or 0.0,
                inertia=today.inertia.value,
                gain=requested.gain,
            )
        if today.coulomb.value == 0.0 and today.viscous.value == 0.0:
            message = "friction_compensation: the model has no friction to compensate; leave it out"
            raise FrictoolError(message).at("design", "friction_compensation")
        smoothing = self._smoothing(requested)
        levels: dict[str, Any] = {"coulomb": today.coulomb.value, "viscous": today.viscous.value}
        if not is_plain(self.model):
            speeds, efforts = signed_friction(self.model, smoothing)
            levels = {"speeds": tuple(speeds.tolist()), "efforts": tuple(efforts.tolist())}
        positions, forward, backward = coulomb_change(self.model)
        if positions.size:
            levels["positions"] = tuple(positions.tolist())
            levels["forward"] = tuple(forward.tolist())
            if not np.array_equal(forward, backward):
                levels["backward"] = tuple(backward.tolist())
        return stored.FrictionCompensation(
            source="model",
            velocity=requested.velocity or "measured",
            smoothing_speed=smoothing,
            gain=requested.gain,
            **levels,
        )

    def _smoothing(self, requested: FrictionCompensationDesign) -> float:
        if requested.smoothing_speed is not None:
            return requested.smoothing_speed.value
        if self.velocity.source == "measured":
            raise FrictoolError(
                "friction_compensation.smoothing_speed: missing, and a measured speed has no "
                "default; write the speed below which the modelled friction decreases to 0"
            ).at("design", "friction_compensation.smoothing_speed")
        block = FeedbackLoop("velocity", low_pass(self.velocity, self.period), (DIFFERENCE,))
        value = drive_after_count(from_position(block), self.model.bench.encoder.resolution)
        return self.record_derived(
            "friction_compensation.smoothing_speed",
            value,
            self.unit("velocity"),
            "peak of the filtered speed after one encoder count",
        )


def _square_root_gain(model: Model, law: PositionLawDesign) -> float:
    today = model.parameters
    factor = 2.0 if law.formula == "sqrt(2F/J)" else 1.0
    force = today.coulomb.value * law.virtual_coulomb_factor
    gain = math.sqrt(factor * force / today.inertia.value)
    if gain <= 0.0:
        raise NoSolutionError(
            "position_law: `kind: square_root` needs Coulomb friction, but the model's coulomb is "
            "0; write `kind: proportional`"
        )
    return gain
