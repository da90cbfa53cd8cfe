"""Parameters of the compared laws in SI, and the scales of the tests.

The inputs of thesis 3.7 are defined for a mass m of 1 kg, a Coulomb friction F_c of 1 N and a time
constant m/sigma_v of 2.5 s, where sigma_v is the coefficient of viscous friction. For another
actuator, the units force, time and length replace the newton, the second and the metre of the
thesis; fall is the relative drop from the breakaway F_s to F_c, divided by its value in the thesis:

    force = F_c
    time = (m/sigma_v)/2.5, or 1 s without viscous friction
    length = F_c time^2/m
    fall = (F_s - F_c)/(F_c/2)

In these units, the amplitudes of stick-slip and limit cycle are proportional to F_s - F_c.
Therefore the speed of the pulled spring is multiplied by `fall`, and the duration of the position
loop is divided by `fall` if this is below 1 (compare/input_protocol.py). The Stribeck velocity v_s,
the presliding displacement z_max and the switching speed Sigma are multiplied by `fall` if no
document states them. The number of stick phases then does not depend on `fall`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictool.documents.friction import Friction
from frictool.documents.quantity import Axis
from frictool.friction.elasto_plastic import PLASTIC_FROM
from frictool.friction.law_extension import NO_EXTENSION, FrictionExtension
from frictool.friction.leuven import DEFAULT_EXPONENT
from frictool.friction.position_polynomial import normalise

TIME_CONSTANT = 2.5  # s, m/sigma_v of table 3.1
# values of table 3.1 in units of force, time and length, for parameters that no log shows
STRIBECK_VELOCITY, PRESLIDING, EFFORT_LIMIT, DEAD_BAND = 1e-3, 1e-5, 2.0, 1e-3
# STEP and SWITCH_VELOCITY are printed as 1e-4, which violates (3.11) and Sigma > 3 v_s
STEP, SWITCH_VELOCITY, DECAY = 4e-5, 4e-3, 1e3
PREISACH_INTERVALS = 20
SHORTEST = 1e-9  # smallest plausible unit of time [s] and length [m]; the largest is 1/SHORTEST
FALL = 0.5  # (F_s - F_c)/F_c of table 3.1
LEAST_FALL = 0.1  # smallest fall to which the tests are scaled, relative to FALL


@dataclass(frozen=True)
class UnitScales:
    """Units of the tests: force [N | N m], time [s] and length [m | rad].

    `breakaway`: breakaway force, divided by `force`.
    """

    force: float
    time: float
    length: float
    breakaway: float

    @property
    def speed(self) -> float:
        """Return the unit of speed [m/s | rad/s]."""
        return self.length / self.time

    @property
    def fall(self) -> float:
        """Return (breakaway - Coulomb)/Coulomb, divided by its value in thesis table 3.1.

        The result is at least LEAST_FALL, which limits the duration of the tests.
        """
        return max((self.breakaway - 1.0) / FALL, LEAST_FALL)


def scales_of(
    mass: float, coulomb: float, breakaway: float, viscous: float, longest: float = math.inf
) -> UnitScales:
    """Return the units of the tests for an actuator.

    For the actuator of thesis table 3.1, the units are 1 N, 1 s and 1 m. The unit of time is at
    most `longest` [s]. Raises ValueError if the units are implausibly large or small.
    """
    time = min(mass / viscous / TIME_CONSTANT, longest) if viscous > 0.0 else min(1.0, longest)
    length = coulomb * time * time / mass
    if not (SHORTEST < time < 1.0 / SHORTEST and SHORTEST < length < 1.0 / SHORTEST):
        raise ValueError(
            f"inertia {mass:g}, coulomb {coulomb:g}, viscous {viscous:g}: the tests' time scale "
            f"is {time:g} s, their length scale {length:g}; "
            f"allowed for both: {SHORTEST:g} to {1.0 / SHORTEST:g}"
        )
    return UnitScales(coulomb, time, length, breakaway / coulomb)


@dataclass(frozen=True)
class ComparisonSetting:
    """Parameters of all laws in SI (N m and rad for a rotary axis).

    `sample_period` [s] and `encoder_step` [m | rad] are values of the bench. They limit the decay
    rate and the switching speed (thesis (3.8), (3.10)). Both are None if there is no bench.
    """

    name: str
    axis: Axis
    mass: float
    coulomb: float
    breakaway: float
    viscous: float
    stribeck_velocity: float
    stribeck_exponent: float
    presliding: float  # z_max
    plastic_from: float  # z_ba/z_max
    leuven_exponent: float  # i of (2.49)
    stiffness: float  # sigma_0 = k_1
    damping: float  # sigma_1 = k_2
    dead_band: float
    effort_limit: float
    step: float  # T_e
    switch_velocity: float  # Sigma
    decay: float  # p_0
    preisach_intervals: int
    scales: UnitScales
    sample_period: float | None = None  # T_s
    encoder_step: float | None = None  # delta_x
    extension: FrictionExtension = NO_EXTENSION  # extensions of the laws


def from_friction(document: Friction) -> ComparisonSetting:
    """Return the parameters of the laws in a `friction.yaml`.

    A stiffness or damping that the document omits is computed by thesis (3.35).
    """
    stiffness = (
        document.bristle_stiffness.value
        if document.bristle_stiffness
        else document.breakaway.value / document.presliding.value
    )
    damping = (
        document.bristle_damping.value
        if document.bristle_damping
        else 2.0 * math.sqrt(document.inertia.value * stiffness)
    )
    return ComparisonSetting(
        name=document.name,
        axis=document.axis,
        mass=document.inertia.value,
        coulomb=document.coulomb.value,
        breakaway=document.breakaway.value,
        viscous=document.viscous.value,
        stribeck_velocity=document.stribeck_velocity.value,
        stribeck_exponent=document.stribeck_exponent,
        presliding=document.presliding.value,
        plastic_from=document.plastic_from,
        leuven_exponent=document.leuven_exponent,
        stiffness=stiffness,
        damping=damping,
        dead_band=document.dead_band.value
        if document.dead_band
        else document.stribeck_velocity.value,
        effort_limit=document.effort_limit.value,
        step=document.hybrid.step_s,
        switch_velocity=document.hybrid.switch_velocity.value,
        decay=document.hybrid.decay_rad_s,
        preisach_intervals=document.hybrid.preisach_intervals,
        scales=scales_of(
            document.inertia.value,
            document.coulomb.value,
            document.breakaway.value,
            document.viscous.value,
        ),
        extension=extension_of(document),
    )


def extension_of(document: Friction) -> FrictionExtension:
    """Return the extensions of the laws in a `friction.yaml`.

    Raises ValueError if a polynomial of the friction over position has no positive mean.
    """
    opposite = document.backward
    by_position = document.position
    film = document.film
    dwell = document.dwell
    fields: dict[str, Any] = {}
    if opposite is not None:
        quantities = {
            "coulomb": opposite.coulomb,
            "breakaway": opposite.breakaway,
            "viscous": opposite.viscous,
        }
        fields["backward_values"] = {
            name: quantity.value for name, quantity in quantities.items() if quantity is not None
        }
    if by_position is not None:
        low, high, forward = by_position.over.low, by_position.over.high, by_position.levels.forward
        fields["travel"] = (low, high)
        for side, coefficients in (
            ("forward", forward),
            ("backward", by_position.levels.backward or forward),
        ):
            fields[side] = tuple(normalise(np.array(coefficients), low, high)[0].tolist())
    if document.regimes:
        below = [document.viscous.value, *(regime.viscous.value for regime in document.regimes)]
        fields["regimes"] = tuple(
            (r.above.value, r.viscous.value - slower)
            for r, slower in zip(document.regimes, below, strict=False)
        )
    if dwell is not None:
        fields |= {"fresh": dwell.fresh, "rise_time": dwell.rise_time_s}
    if film is not None:
        fields |= {"lag": film.lag_s, "boundary": film.boundary.value if film.boundary else 0.0}
    return FrictionExtension(**fields)


def scaled_setting(
    name: str,
    axis: Axis,
    mass: float,
    coulomb: float,
    breakaway: float,
    viscous: float,
    longest: float = math.inf,
) -> ComparisonSetting:
    """Return the parameters of thesis table 3.1, scaled to the actuator in the arguments.

    `longest`: upper limit of the unit of time [s].
    """
    scales = scales_of(mass, coulomb, breakaway, viscous, longest)
    speed = scales.fall * scales.speed
    presliding = PRESLIDING * scales.fall * scales.length
    stiffness = breakaway / presliding
    return ComparisonSetting(
        name=name,
        axis=axis,
        mass=mass,
        coulomb=coulomb,
        breakaway=breakaway,
        viscous=viscous,
        stribeck_velocity=STRIBECK_VELOCITY * speed,
        stribeck_exponent=2.0,
        presliding=presliding,
        plastic_from=PLASTIC_FROM,
        leuven_exponent=DEFAULT_EXPONENT,
        stiffness=stiffness,
        damping=2.0 * math.sqrt(mass * stiffness),
        dead_band=DEAD_BAND * speed,
        effort_limit=EFFORT_LIMIT * scales.force,
        step=STEP * scales.time,
        switch_velocity=SWITCH_VELOCITY * speed,
        decay=DECAY / scales.time,
        preisach_intervals=PREISACH_INTERVALS,
        scales=scales,
    )


def table_3_1() -> ComparisonSetting:
    """Return thesis table 3.1, with three values changed so that every law can be simulated.

    Returns
    -------
    ComparisonSetting
        Table 3.1 with time step T_e = 4e-5 s, switching velocity Sigma = 4e-3 m/s and elastic limit
        z_ba = 0.9 z_max. configs/mass/friction.yaml states the reasons.
    """
    return scaled_setting("table 3.1", "linear", 1.0, 1.0, 1.5, 0.4)
