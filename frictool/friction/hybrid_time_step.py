"""Inequalities that the simulation parameters of the hybrid laws must meet on a rig.

The inequalities, each with its equation or section in the thesis:

    (3.8)   p0 >= 5/T_s                a stuck body stops within one sample of the controller
    (3.10)  Sigma < delta_x p0         a stuck body moves by less than one encoder step
    (3.11)  m Sigma > u_max T_e        no integration step crosses the whole capture range
    (3.31)  T_0 >= T_e_min             the body stays at rest for at least one integration step
    3.2     Sigma > 3 v_s              at the speed Sigma, the Stribeck effect has decayed

A slipping body is captured, which means that the body sticks, if its speed is below Sigma and the
effort in the direction of motion is below the Coulomb friction (hybrid_kernels.py). The classes of
this module define the other symbols.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.friction.hybrid_kernels import CAPTURE_VELOCITY, CONVERGENCE_RATE
from frictool.friction.law import Law
from frictool.friction.parameter import Axis


@dataclass(frozen=True)
class HybridBench:
    """Rig data that limit the simulation parameters of the hybrid laws (versions A to C).

    - sample_period: sample period T_s of the controller, s
    - encoder_step: encoder step delta_x, m | rad
    - inertia: mass or inertia m, kg | kg m^2
    - effort_limit: largest effort u_max, N | N m
    - stribeck_velocity: Stribeck velocity v_s, m/s | rad/s; 0 if the friction drops to the Coulomb
      friction as soon as the body moves
    """

    sample_period: float
    encoder_step: float
    inertia: float
    effort_limit: float
    stribeck_velocity: float = 0.0


@dataclass(frozen=True)
class HybridSettings:
    """Simulation parameters of a hybrid law.

    - convergence_rate: p0, decay rate of the remaining velocity after the switch to stick, 1/s
    - capture_velocity: Sigma, speed below which a slipping body may be captured, m/s | rad/s
    - step, shortest_step: longest and shortest integration step T_e and T_e_min, s
    - hold_time: T_0, shortest time at rest before a breakaway against the direction of the last
      motion, s
    """

    convergence_rate: float
    capture_velocity: float
    step: float
    shortest_step: float = 0.0
    hold_time: float = 0.0


def _positive(owner: HybridBench | HybridSettings, may_be_zero: tuple[str, ...]) -> None:
    for name, value in vars(owner).items():
        if not math.isfinite(value) or value < 0.0 or (value == 0.0 and name not in may_be_zero):
            allowed = ">= 0" if name in may_be_zero else "> 0"
            raise ValueError(f"{name} is {value:g}; allowed: a finite number {allowed}")


def violations(
    law: Law, bench: HybridBench, settings: HybridSettings, axis: Axis = "linear"
) -> list[str]:
    """Return one line with the numbers for each inequality that the settings violate.

    The list is empty for laws that are not hybrid. Raises ValueError if a value is not finite or
    out of range.
    """
    if CAPTURE_VELOCITY not in law.parameters:
        return []
    _positive(bench, ("stribeck_velocity",))
    _positive(settings, ("shortest_step", "hold_time"))
    speed, mass, effort, length = (
        ("m/s", "kg", "N", "m") if axis == "linear" else ("rad/s", "kg m^2", "N m", "rad")
    )
    s, b = settings, bench
    sigma = f"Sigma = {s.capture_velocity:g} {speed}"
    broken = []
    if CONVERGENCE_RATE in law.parameters:
        if s.convergence_rate < 5.0 / b.sample_period:
            broken.append(
                f"p0 >= 5/T_s: p0 = {s.convergence_rate:g} 1/s, 5/T_s = "
                f"{5.0 / b.sample_period:g} 1/s (T_s = {b.sample_period:g} s)"
            )
        if s.capture_velocity >= b.encoder_step * s.convergence_rate:
            value = b.encoder_step * s.convergence_rate
            bound = (
                f"delta_x p0 = {b.encoder_step:g} {length} x {s.convergence_rate:g} 1/s = "
                f"{value:g} {speed}"
            )
            broken.append(f"Sigma < delta_x p0: {sigma}, {bound}")
        if s.hold_time < s.shortest_step:
            broken.append(
                f"T_0 >= T_e_min: T_0 = {s.hold_time:g} s, T_e_min = {s.shortest_step:g} s"
            )
    if b.inertia * s.capture_velocity <= b.effort_limit * s.step:
        left = (
            f"m Sigma = {b.inertia:g} {mass} x {s.capture_velocity:g} {speed} = "
            f"{b.inertia * s.capture_velocity:g} {effort} s"
        )
        right = (
            f"u_max T_e = {b.effort_limit:g} {effort} x {s.step:g} s = "
            f"{b.effort_limit * s.step:g} {effort} s"
        )
        broken.append(f"m Sigma > u_max T_e: {left}, {right}")
    if s.capture_velocity <= 3.0 * b.stribeck_velocity:
        broken.append(f"Sigma > 3 v_s: {sigma}, 3 v_s = {3.0 * b.stribeck_velocity:g} {speed}")
    return broken
