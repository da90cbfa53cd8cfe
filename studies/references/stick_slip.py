"""Slow simulation of the mass of table 3.1: scipy's DOP853 with event functions, at 1e-12."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from frictool.engine.body import FrictionBody
from frictool.engine.drive import EffortFunction
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

MASS, COULOMB, BREAKAWAY, STRIBECK_SPEED, EXPONENT, VISCOUS = 1.0, 1.0, 1.5, 1e-3, 2.0, 0.4
LAYER = 6.4 * STRIBECK_SPEED  # exp(-(0.98 * 6.4)^2) = 8e-18


@kernel
def stribeck(v: float, direction: float, p: Vector) -> float:
    """Return the friction (2.34) at the velocity v; p: F_c, F_s, v_s, delta, sigma_v."""
    dry = p[0] + (p[1] - p[0]) * math.exp(-(abs(v / p[2]) ** p[3]))
    return float(direction * dry + p[4] * v)


def table31(**changes: Any) -> FrictionBody:
    """Return the body of table 3.1; `changes` replace fields of `Body`."""
    fields: dict[str, Any] = {
        "mass": MASS,
        "slip_force": stribeck,
        "law": np.array([COULOMB, BREAKAWAY, STRIBECK_SPEED, EXPONENT, VISCOUS]),
        "breakaway": (BREAKAWAY, BREAKAWAY),
        "coulomb": (COULOMB, COULOMB),
        "viscous": (VISCOUS, VISCOUS),
        "straight_from": LAYER,
        "speed_scale": STRIBECK_SPEED,
    }
    return FrictionBody(**(fields | changes))


def _effort(drive: EffortFunction, t: float, y: Vector) -> float:
    x, v, q = (float(value) for value in y)
    free = (
        drive.offset
        + drive.slope * t
        + drive.amplitude * math.sin(drive.frequency * t + drive.phase)
    )
    return (
        free
        - drive.proportional * (x - drive.target - drive.target_speed * t)
        - drive.derivative * v
        - drive.integral * q
    )


def _slip(
    body: FrictionBody,
    drive: EffortFunction,
    direction: float,
    t: float,
    end: float,
    y: Vector,
    options: dict[str, Any],
) -> tuple[float, Vector, bool]:
    """Simulate a slip from (x, v, q) at t; return its end, the state, and True if it stopped."""

    # a fast body passes the layer in a short time: the integrator must neither step over the layer
    # nor interpolate across its edge
    fast = direction * float(y[1]) > 0.995 * body.straight_from

    def field(at: float, now: Vector) -> list[float]:
        straight = direction * body.coulomb[1] + body.viscous[1] * float(now[1])
        friction = straight if fast else float(body.slip_force.py_func(now[1], direction, body.law))
        return [
            now[1],
            (_effort(drive, at, now) - friction) / body.mass,
            now[0] - drive.target - drive.target_speed * at,
        ]

    def speed(_: float, now: Vector) -> float:
        return direction * float(now[1])

    edge = 0.99 * body.straight_from if fast else body.straight_from

    def above_edge(_: float, now: Vector) -> float:
        return direction * float(now[1]) - edge

    stop: Any = speed
    layer: Any = above_edge
    stop.terminal, stop.direction = True, -1
    layer.terminal, layer.direction = True, -1 if fast else 1
    longest = 0.05 if fast else 0.1 * body.straight_from / (abs(field(t, y)[1]) + 0.05)
    solution = solve_ivp(field, (t, end), y, events=(stop, layer), max_step=longest, **options)
    return float(solution.t[-1]), solution.y[:, -1], bool(solution.t_events[0].size)


def _breakaway(
    body: FrictionBody, drive: EffortFunction, t: float, end: float, y: Vector
) -> tuple[float, float]:
    """Return time and direction of the breakaway of a body that rests from t on.

    Return (end, 0) without a breakaway before `end`.
    """

    def at(s: float) -> float:
        rate = float(y[0]) - drive.target
        moved = rate * (s - t) - 0.5 * drive.target_speed * (s * s - t * t)
        return _effort(drive, s, np.array([y[0], 0.0, y[2] + moved]))

    grid = np.linspace(t, end, 20_001)
    for direction, threshold in ((-1.0, body.breakaway[0]), (1.0, body.breakaway[1])):
        if direction * at(t) > threshold:
            return t, direction
    over = [
        (s, d)
        for d, f in ((-1.0, body.breakaway[0]), (1.0, body.breakaway[1]))
        for s in grid[1:]
        if d * at(float(s)) > f
    ][:1]
    first = min(((float(s), d) for s, d in over), default=None)
    if first is None:
        return end, 0.0
    threshold = body.breakaway[1 if first[1] > 0 else 0]

    def gap(s: float) -> float:
        return first[1] * at(s) - threshold

    return float(
        brentq(gap, first[0] - (end - t) / 20_000, first[0], xtol=1e-15, rtol=1e-15)
    ), first[1]


TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-15}


def reference_breakaways(
    body: FrictionBody, drive: EffortFunction, end: float, options: dict[str, Any] = TIGHT
) -> tuple[list[float], Vector]:
    """Return the breakaway times from rest at 0 up to `end`, and the state (3,) at `end`.

    The state is position, velocity and integral of the position error.
    """
    t, y, found, direction = 0.0, np.zeros(3), [], 0.0
    while t < end:
        if direction == 0.0:
            later, direction = _breakaway(body, drive, t, end, y)
            y = np.array(
                [
                    y[0],
                    0.0,
                    y[2]
                    + (y[0] - drive.target) * (later - t)
                    - 0.5 * drive.target_speed * (later**2 - t**2),
                ]
            )
            t = later
            if direction:
                found.append(t)
            continue
        t, y, stopped = _slip(body, drive, direction, t, end, y, options)
        if stopped:
            y, direction = np.array([y[0], 0.0, y[2]]), 0.0
    return found, y
