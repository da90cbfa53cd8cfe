"""What the laws are compared with: the parameters of table 3.1, or of any actuator, in SI, and the
scales of the tests.

The inputs of 3.7 are written for a mass of 1 kg, 1 N of Coulomb friction and a time constant
m/sigma_v of 2.5 s. Any other actuator is tested by similarity: its force, time and length stand for
the newton, second and metre of the thesis.

    force = F_c        time = (m/sigma_v)/2.5        length = F_c time^2/m        (time = 1 s
                       without viscous friction)
    fall  = (F_s - F_c)/(F_c/2)

The amplitudes of stick-slip and limit cycle are proportional to the fall of the friction from F_s
to F_c, in these units. The pull's speed and the loop's duration follow it
(compare/input_protocol.py), and so do v_s, z_max and Sigma where nobody knows them: an actuator
whose friction falls little sticks and slips as often, and is as rigid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictool.documents.friction import Friction
from frictool.documents.quantity import Axis
from frictool.friction.extension import NO_EXTENSION, FrictionExtension
from frictool.friction.position_polynomial import normalise

TIME_CONSTANT = 2.5  # s: m/sigma_v of table 3.1
# of table 3.1, in units of force, time and length: for an actuator whose log cannot show them
STRIBECK_VELOCITY, PRESLIDING, EFFORT_LIMIT, DEAD_BAND = 1e-3, 1e-5, 2.0, 1e-3
STEP, SWITCH_VELOCITY, DECAY = (
    4e-5,
    4e-3,
    1e3,
)  # printed: 1e-4, 1e-4, which break (3.11) and Sigma > 3 v_s
PLASTIC_FROM, LEUVEN_EXPONENT, PREISACH_INTERVALS = 0.9, 10.0, 20
SHORTEST = 1e-9  # s, m: a machine is not smaller, nor larger than 1e9
FALL, LEAST_FALL = (
    0.5,
    0.1,
)  # (F_s - F_c)/F_c of table 3.1; the least that the tests are scaled to, in units of it


@dataclass(frozen=True)
class UnitScales:
    """The units of the tests: force [N | N m], time [s], length [m | rad]; `breakaway`: F_s in
    units of force."""

    force: float
    time: float
    length: float
    breakaway: float

    @property
    def speed(self) -> float:
        """[m/s | rad/s]"""
        return self.length / self.time

    @property
    def fall(self) -> float:
        """F_s - F_c over that of table 3.1, and at least LEAST_FALL: with less a test would last
        for ever."""
        return max((self.breakaway - 1.0) / FALL, LEAST_FALL)


def scales_of(
    mass: float, coulomb: float, breakaway: float, viscous: float, longest: float = math.inf
) -> UnitScales:
    """The units of the tests for an actuator, that of time at most `longest` [s]; 1 N, 1 s, 1 m for
    table 3.1.

    ValueError where no machine can have such parameters.
    """
    time = min(mass / viscous / TIME_CONSTANT, longest) if viscous > 0.0 else min(1.0, longest)
    length = coulomb * time * time / mass
    if not (SHORTEST < time < 1.0 / SHORTEST and SHORTEST < length < 1.0 / SHORTEST):
        raise ValueError(
            f"inertia {mass:g}, coulomb {coulomb:g} and viscous {viscous:g} make {time:g} s and {length:g} the units of time and length "
            f"of the tests; allowed: {SHORTEST:g} to {1.0 / SHORTEST:g}"
        )
    return UnitScales(coulomb, time, length, breakaway / coulomb)


@dataclass(frozen=True)
class ComparisonSetting:
    """Every parameter of every law, SI (N m and rad where the axis is rotary).

    `sample_period`, `encoder_step`: what (3.8) and (3.10) are about, None where there is no bench.
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
    extension: FrictionExtension = NO_EXTENSION  # what the laws take on top


def from_friction(document: Friction) -> ComparisonSetting:
    """The setting of a `friction.yaml`; stiffness and damping by (3.35) where it gives none."""
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
    """What a `friction.yaml` puts on top of the laws. ValueError where a polynomial of position has
    no positive mean."""
    opposite, place, film, dwell = (
        document.backward,
        document.position,
        document.film,
        document.dwell,
    )
    found: dict[str, Any] = {}
    if opposite is not None:
        given = {
            "coulomb": opposite.coulomb,
            "breakaway": opposite.breakaway,
            "viscous": opposite.viscous,
        }
        found["backward_values"] = {
            name: quantity.value for name, quantity in given.items() if quantity is not None
        }
    if place is not None:
        low, high, forward = place.over.low, place.over.high, place.levels.forward
        found["travel"] = (low, high)
        for side, coefficients in (
            ("forward", forward),
            ("backward", place.levels.backward or forward),
        ):
            found[side] = tuple(normalise(np.array(coefficients), low, high)[0].tolist())
    if document.regimes:
        below = [document.viscous.value, *(regime.viscous.value for regime in document.regimes)]
        found["regimes"] = tuple(
            (r.above.value, r.viscous.value - slower)
            for r, slower in zip(document.regimes, below, strict=False)
        )
    if dwell is not None:
        found |= {"fresh": dwell.fresh, "rise_time": dwell.rise_time_s}
    if film is not None:
        found |= {"lag": film.lag_s, "boundary": film.boundary.value if film.boundary else 0.0}
    return FrictionExtension(**found)


def scaled_setting(
    name: str,
    axis: Axis,
    mass: float,
    coulomb: float,
    breakaway: float,
    viscous: float,
    longest: float = math.inf,
) -> ComparisonSetting:
    """Table 3.1 at the actuator's scales (`longest`: of `scales_of`), with what is known of the
    actuator in its place."""
    scales = scales_of(mass, coulomb, breakaway, viscous, longest)
    speed, presliding = scales.fall * scales.speed, PRESLIDING * scales.fall * scales.length
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
        leuven_exponent=LEUVEN_EXPONENT,
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
    """Table 3.1 as it can be simulated: T_e = 4e-5 s, Sigma = 4e-3 m/s, z_ba = 0.9 z_max (the text
    of configs/mass/friction.yaml)."""
    return scaled_setting("table 3.1", "linear", 1.0, 1.0, 1.5, 0.4)
