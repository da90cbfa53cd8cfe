"""The lubricant film between velocity and friction: frictional memory (3.4.2.3) and the regimes of
figure 2.16.

The dry part of a law is taken at the film's velocity w, its viscous part at the body's:    F =
                                                                                            F_law(w)
                                                                                            +
                                                                                            sigma_v
                                                                                            (v - w)

    frictional memory     w follows v through a lag, w' = (v - w)/tau, or through a pure delay
    boundary lubrication  no film forms below v_b:  w = sign(v) max(0, |v| - v_b)

regime  name      where                                  friction
======  ========  =====================================  =======================================
1       STATIC    v = 0                                  holds, up to the breakaway
2       BOUNDARY  0 < |v| <= v_b                         as if dry, independent of the velocity but
        for sigma_v
3       PARTIAL   up to the minimum of the curve         falls: Stribeck's effect
4       FULL      beyond                                 rises: viscous
======  ========  =====================================  =======================================
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.friction.stribeck import STRIBECK_EXPONENT, STRIBECK_VELOCITY, VISCOUS, slip_slope
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]
STATIC, BOUNDARY, PARTIAL, FULL = 1, 2, 3, 4


@kernel
def film_force(at_film: float, v: float, film: float, viscous: float) -> float:
    """Friction [N | N m] at v where the law gives `at_film` at the film's velocity; `viscous`: the
    law's sigma_v."""
    return at_film + viscous * (v - film)


@kernel
def boundary_film(v: float, boundary: float) -> float:
    """Film velocity above boundary lubrication [m/s | rad/s]."""
    return math.copysign(max(0.0, abs(v) - boundary), v)


@kernel
def lagged_film(film: float, v_start: float, v_end: float, lag: float, step: float) -> float:
    """Film velocity after `step` [s] in which v goes straight from v_start to v_end: the exact
    response of the lag [s]."""
    if lag == 0.0:
        return v_end
    slope = (v_end - v_start) / step
    return v_end - slope * lag + (film - v_start + slope * lag) * math.exp(-step / lag)


@kernel
def delayed_film(history: Vector, v: float) -> float:
    """Film velocity of n samples ago; history (n + 1,) is [place, the last n velocities], in place.
    An empty one does not delay."""
    count = history.shape[0] - 1
    if count == 0:
        return v
    place = 1 + int(history[0])
    film = history[place]
    history[place] = v
    history[0] = place % count
    return float(film)


@kernel
def full_film_velocity(p: Vector) -> float:
    """Where Stribeck's curve (friction/stribeck.py) has its minimum [m/s | rad/s]: 0 if it never
    falls, inf if it never rises again."""
    exponent, scale = p[STRIBECK_EXPONENT], p[STRIBECK_VELOCITY]
    steepest = scale * ((exponent - 1.0) / exponent) ** (1.0 / exponent) if exponent > 1.0 else 0.0
    if slip_slope(steepest, 1.0, p) >= 0.0:
        return 0.0
    if p[VISCOUS] == 0.0:
        return math.inf
    low, high = steepest, 2.0 * max(scale, steepest)
    while slip_slope(high, 1.0, p) < 0.0:
        low, high = high, 2.0 * high
    middle = 0.5 * (low + high)
    while low < middle < high:
        if slip_slope(middle, 1.0, p) < 0.0:
            low = middle
        else:
            high = middle
        middle = 0.5 * (low + high)
    return float(high)


@kernel
def regime(v: float, boundary: float, p: Vector) -> int:
    """The lubrication regime at v: the table above."""
    if v == 0.0:
        return STATIC
    if abs(v) <= boundary:
        return BOUNDARY
    return PARTIAL if abs(v) - boundary < full_film_velocity(p) else FULL
