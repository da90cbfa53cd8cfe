"""Stribeck's law (thesis 2.33-2.34) and its curve g(v), which dynamic and hybrid laws also use.

    g(v) = F_c + (F_s - F_c) exp(-|v/v_s|^delta)       slip friction without the viscous part
    F(v) = g(v) sign(v) + sigma_v v

F_c is the Coulomb friction, F_s the breakaway, v_s the Stribeck velocity, delta an exponent, and
sigma_v the viscous coefficient. The other laws use g(v) in (2.39) and (3.4). Equation (2.39) has
v/v_s instead of the modulus |v/v_s| of (2.34). The code has the modulus, since a negative v/v_s
with an odd or fractional delta makes no sense.
"""

from __future__ import annotations

import math

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import STRIBECK
from frictool.friction.static_kernels import breakaway_level, no_band, true_velocity
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

# indices of the curve's parameters in p, the same in every law that uses the curve
COULOMB, BREAKAWAY, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS = 0, 1, 2, 3, 4
FALLEN = 700.0  # exp(-FALLEN) is negligible; larger arguments would overflow
ROUNDING_EXPONENT = 38.4  # exp(-0.98^2 38.4) = 1e-16: the curve is F_c to rounding


def straight_from(velocity: float, exponent: float) -> float:
    """Return the speed [m/s | rad/s] above which g(v) is F_c within the rounding error."""
    return velocity * float(ROUNDING_EXPONENT ** (1.0 / exponent))


@kernel
def _power(ratio: float, exponent: float) -> float:
    if exponent == 2.0:
        return ratio * ratio
    return ratio if exponent == 1.0 else ratio**exponent


@kernel
def curve(v: float, p: Vector) -> float:
    """Return g(v), the friction in slip without the viscous part [N | N m]; g(-v) = g(v)."""
    fall = _power(abs(v) / p[STRIBECK_VELOCITY], p[STRIBECK_EXPONENT])
    return float(p[COULOMB] + (p[BREAKAWAY] - p[COULOMB]) * math.exp(-fall))


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Return the friction [N | N m] against a motion in `direction` at the velocity v."""
    return float(direction * curve(v, p) + p[VISCOUS] * v)


@kernel
def slip_slope(v: float, direction: float, p: Vector) -> float:
    """Return d(slip_force)/dv; -inf at v = 0 for an exponent below 1."""
    drop = p[BREAKAWAY] - p[COULOMB]
    exponent = p[STRIBECK_EXPONENT]
    ratio = abs(v) / p[STRIBECK_VELOCITY]
    if drop == 0.0:
        return float(p[VISCOUS])
    if ratio == 0.0 and exponent < 1.0:
        return -math.inf
    fall = _power(ratio, exponent)
    if fall > FALLEN:
        return float(p[VISCOUS])
    return float(
        p[VISCOUS]
        - drop * exponent / p[STRIBECK_VELOCITY] * _power(ratio, exponent - 1.0) * math.exp(-fall)
    )


def _scales(p: Vector) -> tuple[float, float]:
    velocity, exponent = float(p[STRIBECK_VELOCITY]), float(p[STRIBECK_EXPONENT])
    return straight_from(velocity, exponent), velocity


LAW = Law(
    "stribeck",
    "Stribeck",
    "(2.33)-(2.34)",
    STRIBECK,
    StaticKernels(slip_force, breakaway_level, no_band, true_velocity),
    slip_scales=_scales,
    slip_terms=("coulomb", "stribeck", "viscous"),
)
