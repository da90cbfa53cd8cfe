"""Parameters of a law comparison for an identified actuator, from its model and bench.

A parameter that neither document contains has the value of thesis table 3.1, scaled to the units of
length and time of compare/comparison_setting.py. m is the inertia, F_s the breakaway, F_c the
Coulomb friction, sigma_v the viscous coefficient, v_s the Stribeck velocity, z_max the largest
presliding displacement, k_1 and k_2 the stiffness and damping of presliding, T_s the controller's
sample period, delta_x the encoder's step, and T_e the time step of the simulation. `fall` is (F_s -
F_c)/F_c, divided by the value of this quotient in table 3.1. The numbers in parentheses are
equations of the thesis.

unit of time   (m/sigma_v)/2.5; shorter if the tests would exceed the bench's travel or top speed
v_s            1e-3 fall (unit of length)/(unit of time); at most delta_x p0/5
z_max          1e-5 fall (unit of length)
k_1, k_2       k_1 = sigma_0 = F_s/z_max, k_2 = sigma_1 = 2 sqrt(m k_1)                  (3.35)
p0             5/T_s, decay rate of the remaining velocity after the switch to stick      (3.8)
Sigma          4 v_s, and thus below delta_x p0; switching speed                  (3.2), (3.10)
dv             v_s; Karnopp's law treats speeds below dv as rest
T_e            the smallest of 0.8 m Sigma/u_max (3.11), 0.8 m dv/(2 F_s), 1/p0 and
               sqrt(m/k_1)/20; u_max is the largest effort of the drive
"""

from __future__ import annotations

import math
from dataclasses import replace

from frictool.compare.comparison_setting import EFFORT_LIMIT, ComparisonSetting, scaled_setting
from frictool.documents.bench import Bench
from frictool.documents.model import Model

TRAVEL_NEEDED = 8.0  # travel that the tests need, units of length
SPEED_NEEDED = 1.0  # speed that the tests need, units of speed
WITHIN_ENCODER = 0.8  # largest Sigma relative to its bound (3.10); limits Sigma for a fine encoder
ABOVE_STRIBECK = 4.0  # Sigma in units of v_s; section 3.2 requires more than 3
WITHIN_STEP = 0.8  # T_e in units of its bound (3.11)
STUCK_IN_A_SAMPLE = 5.0  # p0 T_s, from (3.8)
CONTACT_STEPS = 20.0  # number of time steps in sqrt(m/k_1)


def from_model(model: Model) -> ComparisonSetting:
    """Return the comparison parameters of an identified actuator.

    A breakaway below the Coulomb friction is replaced by the Coulomb friction. Raises ValueError if
    the actuator has no Coulomb friction, or if the drive cannot overcome the breakaway.
    """
    parameters, bench = model.parameters, model.bench
    mass, coulomb = parameters.inertia.value, parameters.coulomb.value
    if coulomb <= 0.0:
        raise ValueError(
            "parameters.coulomb: found 0; allowed: above 0, because the compared laws need dry "
            "friction"
        )
    breakaway = max(parameters.breakaway.value, coulomb)
    limit = bench.actuator.constant.value * bench.actuator.limit.value
    if limit <= breakaway:
        raise ValueError(
            f"bench.actuator gives at most {limit:g} N m (N); allowed: more than "
            f"parameters.breakaway, {breakaway:g} N m (N)"
        )
    setting = scaled_setting(
        model.name,
        model.axis,
        mass,
        coulomb,
        breakaway,
        parameters.viscous.value,
        _longest(bench, mass, coulomb),
    )
    return _on_bench(setting, bench, max(limit, EFFORT_LIMIT * coulomb))


def _longest(bench: Bench, mass: float, coulomb: float) -> float:
    """Return the largest unit of time [s] for which the tests fit the bench's travel and speed."""
    travel = bench.mechanics.travel
    speed = bench.mechanics.top_speed
    acceleration = coulomb / mass
    by_travel = (
        math.sqrt((travel.high - travel.low) / (TRAVEL_NEEDED * acceleration))
        if travel
        else math.inf
    )
    return min(by_travel, speed.value / (SPEED_NEEDED * acceleration) if speed else math.inf)


def _on_bench(setting: ComparisonSetting, bench: Bench, effort_limit: float) -> ComparisonSetting:
    mass = setting.mass
    resolution = bench.encoder.resolution
    decay = STUCK_IN_A_SAMPLE / bench.sample_period_s
    speed = min(setting.stribeck_velocity, WITHIN_ENCODER * resolution * decay / ABOVE_STRIBECK)
    capture = ABOVE_STRIBECK * speed
    captured = WITHIN_STEP * mass * capture / effort_limit
    rested = WITHIN_STEP * mass * speed / (2.0 * setting.breakaway)
    return replace(
        setting,
        stribeck_velocity=speed,
        dead_band=speed,
        effort_limit=effort_limit,
        step=min(
            captured, rested, 1.0 / decay, math.sqrt(mass / setting.stiffness) / CONTACT_STEPS
        ),
        switch_velocity=capture,
        decay=decay,
        sample_period=bench.sample_period_s,
        encoder_step=resolution,
    )
