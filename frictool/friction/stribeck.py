"""Stribeck's law (2.33)-(2.34), and the curve g(v) that the dynamic and hybrid laws take from it,
(2.39), (3.4).

    g(v) = F_c + (F_s - F_c) exp(-|v/v_s|^delta)            the friction in slip without its viscous
                                                            part
    F(v) = g(v) sign(v) + sigma_v v

(2.39) prints (v/v_s)^delta without the modulus: |v/v_s| as in (2.34) is meant, or an odd or broken
delta makes no sense for v < 0.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import STRIBECK
from frictool.friction.static_kernels import breakaway_level, no_band, true_velocity
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]

# where the parameters of the curve lie in p, in every law that takes it
COULOMB, BREAKAWAY, STRIBECK_VELOCITY, STRIBECK_EXPONENT, VISCOUS = 0, 1, 2, 3, 4
FALLEN = 700.0  # exp(-FALLEN) is nothing beside any force; beyond, its factors would overflow
ROUNDING_EXPONENT = 38.4  # exp(-0.98^2 38.4) = 1e-16: from there on the curve is F_c to rounding


def straight_from(velocity: float, exponent: float) -> float:
    """The speed [m/s | rad/s] from which on the curve of this v_s and delta is F_c to rounding."""
    return velocity * float(ROUNDING_EXPONENT ** (1.0 / exponent))


@kernel
def _power(ratio: float, exponent: float) -> float:
    """ratio^exponent for ratio >= 0; the usual exponents without pow."""
    if exponent == 2.0:
        return ratio * ratio
    return ratio if exponent == 1.0 else ratio**exponent


@kernel
def curve(v: float, p: Vector) -> float:
    """g(v) [N | N m], even in v, between F_c and F_s."""
    fall = _power(abs(v) / p[STRIBECK_VELOCITY], p[STRIBECK_EXPONENT])
    return float(p[COULOMB] + (p[BREAKAWAY] - p[COULOMB]) * math.exp(-fall))


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Friction [N | N m] that opposes a motion at v in `direction`."""
    return float(direction * curve(v, p) + p[VISCOUS] * v)


@kernel
def slip_slope(v: float, direction: float, p: Vector) -> float:
    """Derivative of `slip_force` by v; -inf at v = 0 for an exponent below 1."""
    drop, exponent = p[BREAKAWAY] - p[COULOMB], p[STRIBECK_EXPONENT]
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


LAW = Law(
    "stribeck",
    "Stribeck",
    "(2.33)-(2.34)",
    STRIBECK,
    StaticKernels(slip_force, slip_slope, breakaway_level, no_band, true_velocity),
)
