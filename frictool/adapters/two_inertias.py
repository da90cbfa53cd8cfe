"""Plants of two inertias that agree with an oscillation which an axis shows.

    J_m x_m'' = u - c (x_m' - x_l') - k (x_m - x_l) - friction of the motor
    J_l x_l'' =     c (x_m' - x_l') + k (x_m - x_l) - friction of the load

The sum J of the inertias is known, but neither their ratio nor the place of the encoder. After a
stop, friction holds the body without the encoder. The other body oscillates at sqrt(k/J_m) (encoder
on the motor) or sqrt(k/J_l) (encoder on the load). With little friction, and while the axis moves,
both bodies oscillate, at sqrt(k J/(J_m J_l)). For each ratio, each place of the encoder, and one or
two oscillating bodies, k and c are chosen to give the measured frequency and damping.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from frictool.documents.mechanism import (
    Block,
    Compliance,
    Control,
    Coupling,
    FrictionOf,
    Mechanism,
    Sensor,
    Source,
)
from frictool.documents.model import Model, Parameters
from frictool.documents.quantity import Axis, Quantity, si_unit
from frictool.documents.resonances import Oscillation, Resonances, Ringing

Body = Literal["motor", "load"]
RATIOS = (0.1, 0.3, 1.0, 3.0, 10.0)  # inertia of the load divided by the inertia of the motor
MOST_DAMPED = 0.99  # largest damping ratio of an oscillation
OTHER: dict[Body, Body] = {"motor": "load", "load": "motor"}


@dataclass(frozen=True)
class TwoInertias:
    """Plant of two inertias that reproduces an oscillation of an axis.

    - oscillation: oscillation of the axis, after it stops or in motion
    - ratio: inertia of the load divided by the inertia of the motor
    - encoder: body with the encoder
    - rests: True if the other body rests during the oscillation, False if both oscillate
    """

    oscillation: Ringing
    ratio: float
    encoder: Body
    rests: bool

    @property
    def name(self) -> str:
        """Return a text that names the body with the encoder and the ratio of the inertias."""
        return f"encoder on the {self.encoder}, load/motor inertia {self.ratio:g}"

    @property
    def share(self) -> float:
        """Return the inertia of the body with the encoder divided by the sum of the inertias."""
        motor = 1.0 / (1.0 + self.ratio)
        return motor if self.encoder == "motor" else 1.0 - motor

    @property
    def pole(self) -> float:
        """Return (frequency at which both bodies oscillate)/(frequency of the oscillation)."""
        return 1.0 / math.sqrt(1.0 - self.share) if self.rests else 1.0

    def resonances(self) -> Resonances:
        """Return the poles and zeros between the effort of the motor and the encoder."""
        rate, damping = self.oscillation.rad_s, self.oscillation.damping
        poles = (self._pair(self.pole),)
        if self.encoder == "motor":
            # the motor's share of the inertia reduces the frequency of the load alone
            zero = self._pair(self.pole * math.sqrt(self.share))
            return Resonances(poles, (self.name,), (zero,))
        real = (rate / (2.0 * damping),) if damping > 0.0 else ()
        return Resonances(poles, (self.name,), real_zeros_rad_s=real)

    def _pair(self, factor: float) -> Oscillation:
        one = self.oscillation.scaled(factor)
        damping = max(-MOST_DAMPED, min(factor * one.damping, MOST_DAMPED))
        return Oscillation(one.rad_s, damping, one.interval_rad_s)

    def mechanism(self, model: Model) -> Mechanism:
        """Return the mechanism with the parameters of `model`.

        The friction acts on the body without the encoder, and the offset on the load. The `laws` of
        the model are left out.
        """
        bench, today, axis = model.bench, model.parameters, model.axis
        total = today.inertia.value
        motor = total / (1.0 + self.ratio)
        load = total - motor
        stiffness = (self.pole * self.oscillation.rad_s) ** 2 * motor * load / total
        damping = stiffness * 2.0 * max(self.oscillation.damping, 0.0) / self.oscillation.rad_s
        actuator = bench.actuator
        return Mechanism(
            format="mechanism/1",
            name=model.name,
            blocks={"motor": _block(motor, axis), "load": _block(load, axis)},
            sample_period_s=bench.sample_period_s,
            delay_samples=bench.delay_samples,
            links={
                "drive_train": Coupling(
                    ("motor", "load"),
                    Compliance(
                        Quantity(stiffness, unit=si_unit("stiffness", axis)),
                        Quantity(damping, unit=si_unit("viscous", axis)),
                    ),
                ),
                "friction": _friction(today, OTHER[self.encoder]),
            },
            sources={
                "drive": Source(
                    on="motor",
                    drive=actuator.drive,
                    constant=actuator.constant,
                    limit=actuator.limit,
                    loop_time_constant_s=actuator.loop_time_constant_s,
                    winding=actuator.winding,
                ),
                "offset": Source(
                    on="load",
                    drive="effort",
                    effort=Quantity(-today.offset.value, unit=si_unit("effort", axis)),
                ),
            },
            sensors={
                "encoder": Sensor(
                    self.encoder,
                    step=Quantity(bench.encoder.resolution, unit=si_unit("position", axis)),
                )
            },
            control=Control("drive", "encoder", "load"),
            travel=bench.mechanics.travel,
        )


def two_inertias(oscillation: Ringing) -> Iterator[TwoInertias]:
    """Yield the plants of two inertias that reproduce an oscillation of an axis."""
    yield TwoInertias(oscillation, 1.0, "load", False)
    for ratio in RATIOS:
        if not oscillation.in_motion:
            yield TwoInertias(oscillation, ratio, "load", True)
            yield TwoInertias(oscillation, ratio, "motor", True)
        yield TwoInertias(oscillation, ratio, "motor", False)


def _block(inertia: float, axis: Axis) -> Block:
    quantity = Quantity(inertia, unit=si_unit("inertia", axis))
    return Block(inertia=quantity) if axis == "rotary" else Block(mass=quantity)


def _friction(today: Parameters, body: Body) -> FrictionOf:
    law = "svc" if today.stribeck_velocity is None else "stribeck"
    names = ("coulomb", "breakaway", "viscous", "stribeck_velocity")
    estimates = {name: getattr(today, name) for name in names}
    parameters = {
        name: Quantity(one.value, unit=one.unit)
        for name, one in estimates.items()
        if one is not None
    }
    return FrictionOf(body, law, parameters)
