"""The lubricant film between the surfaces: frictional memory and lubrication regimes.

The film has a velocity w (section 3.4.2.3 of the thesis). The dry part of a law depends on w. The
viscous part, with the coefficient sigma_v, depends on the velocity v of the body:

    F = F_law(w) + sigma_v (v - w)

    frictional memory     w follows v through a lag tau, w' = (v - w)/tau, or through a pure delay
    boundary lubrication  no film forms below the speed v_b: w = sign(v) max(0, |v| - v_b)

The regimes of figure 2.16 of the thesis are:

======  ========  =========================  ======================================
regime  name      velocity                   friction
======  ========  =========================  ======================================
1       STATIC    v = 0                      equals the effort, up to the breakaway
2       BOUNDARY  0 < |v| <= v_b             constant, apart from sigma_v v
3       PARTIAL   up to the curve's minimum  falls with speed: Stribeck's effect
4       FULL      above the minimum          rises with speed: viscous
======  ========  =========================  ======================================
"""

from __future__ import annotations

import math

from frictool.friction.stribeck import STRIBECK_EXPONENT, STRIBECK_VELOCITY, VISCOUS, slip_slope
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

STATIC, BOUNDARY, PARTIAL, FULL = 1, 2, 3, 4


@kernel
def film_force(at_film: float, v: float, film: float, viscous: float) -> float:
    """Return the friction F = `at_film` + viscous (v - film) [N | N m] at velocity v.

    - at_film: friction of the law at the velocity `film` of the film
    - viscous: coefficient sigma_v
    """
    return at_film + viscous * (v - film)


@kernel
def boundary_film(v: float, boundary: float) -> float:
    """Return the film velocity w [m/s | rad/s] of a body with velocity v in boundary lubrication.

    w is 0 up to |v| = `boundary`; above this speed, |w| = |v| - boundary.
    """
    return math.copysign(max(0.0, abs(v) - boundary), v)


@kernel
def lagged_film(film: float, v_start: float, v_end: float, lag: float, step: float) -> float:
    """Return the film velocity after `step` [s] in which v changes linearly from v_start to v_end.

    film: film velocity at the start. The result is the exact solution of w' = (v - w)/lag; `lag` is
    in s.
    """
    if lag == 0.0:
        return v_end
    slope = (v_end - v_start) / step
    return v_end - slope * lag + (film - v_start + slope * lag) * math.exp(-step / lag)


@kernel
def delayed_film(history: Vector, v: float) -> float:
    """Return the velocity n samples ago as the film velocity, and store v in `history` (n + 1,).

    history: index of the oldest velocity, then the last n velocities. If n = 0, v is returned.
    """
    count = history.shape[0] - 1
    if count == 0:
        return v
    index = 1 + int(history[0])
    film = history[index]
    history[index] = v
    history[0] = index % count
    return float(film)


@kernel
def full_film_velocity(p: Vector) -> float:
    """Return the velocity [m/s | rad/s] at the minimum of Stribeck's curve (friction/stribeck.py).

    The result is 0 if the curve never falls and inf if it never rises again.
    """
    exponent, scale = p[STRIBECK_EXPONENT], p[STRIBECK_VELOCITY]
    steepest = scale * ((exponent - 1.0) / exponent) ** (1.0 / exponent) if exponent > 1.0 else 0.0
    if slip_slope(steepest, 1.0, p) >= 0.0:
        return 0.0
    if p[VISCOUS] == 0.0:
        return math.inf
    low = steepest
    high = 2.0 * max(scale, steepest)
    while slip_slope(high, 1.0, p) < 0.0:
        low = high
        high = 2.0 * high
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
    """Return the lubrication regime, STATIC to FULL, at velocity v (table of this module).

    `boundary` is v_b, the speed below which no film forms. p holds the parameters of Stribeck's
    curve.
    """
    if v == 0.0:
        return STATIC
    if abs(v) <= boundary:
        return BOUNDARY
    return PARTIAL if abs(v) - boundary < full_film_velocity(p) else FULL
