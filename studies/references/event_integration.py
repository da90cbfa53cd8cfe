"""Two slow methods to simulate an axis, with which the engine is compared.

`time_stepping`: small implicit steps in which friction is a projection (Moreau), without modes and
events; first order in the step. `event_integration`: scipy's Dormand-Prince method of order 8
through each phase, with event functions; accurate to about 1e-10. It also has the load, the
Stribeck curve and the end stops.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from frictool.plant.axis import AxisParameters
from frictool.plant.position_load import PositionLoad
from frictool.typing import Vector


def limited(p: AxisParameters, command: float) -> float:
    return min(max(command, -p.drive_limit), p.drive_limit)


def time_stepping(
    p: AxisParameters, state: Vector, command: float, duration: float, step: float
) -> tuple[float, float, float]:
    """Return (position, velocity, gap) after `duration`.

    The breakaway must equal the Coulomb friction, because the projection has one friction level.
    """
    assert p.breakaway == p.coulomb
    assert p.backlash_breakaway == p.backlash_coulomb
    x, v, drive, gap = (float(value) for value in state[:4])
    u, half, count = limited(p, command), 0.5 * p.backlash, max(1, round(duration / step))
    h = duration / count
    decay = math.exp(-h / p.lag) if p.lag > 0 else 0.0
    for _ in range(count):
        drive = u + (drive - u) * decay
        effort = p.constant * drive - p.offset
        towards = v if v != 0.0 else effort
        engaged = gap >= half if towards > 0 else gap <= -half
        coulomb, viscous = (p.coulomb, p.viscous) if engaged else (p.backlash_coulomb, 0.0)
        free = v + h * effort / p.inertia
        v = math.copysign(max(0.0, abs(free) - h * coulomb / p.inertia), free) / (
            1.0 + h * viscous / p.inertia
        )
        x += h * v
        gap = min(max(gap + h * v, -half), half)
    return x, v, gap


TIGHT: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "max_step": 1e-4}
UNLOADED = PositionLoad()
STOPS = {-1.0: 0, 1.0: 1}  # index of the end stop ahead


def opposing(p: AxisParameters, load: PositionLoad, x: float) -> float:
    """Return offset plus load at x [N m | N]."""
    total = p.offset + load.stiffness * x
    for number, sine, cosine in load.harmonics:
        total += sine * math.sin(number * x) + cosine * math.cos(number * x)
    return total


def friction_in_slip(p: AxisParameters, engaged: bool, w: float) -> float:
    """Return the friction at the speed w >= 0; `engaged`: True if the motor carries the load."""
    if not engaged:
        return p.backlash_coulomb
    scale, exponent = p.laws.stribeck_velocity, p.laws.stribeck_exponent
    falling = (
        (p.breakaway - p.coulomb) * math.exp(-((abs(w) / scale) ** exponent))
        if scale > 0.0
        else 0.0
    )
    return p.coulomb + falling + p.viscous * w


def event_integration(
    p: AxisParameters,
    state: Vector,
    command: float,
    duration: float,
    options: dict[str, Any] = TIGHT,
    load: PositionLoad = UNLOADED,
) -> tuple[float, float, float, float]:
    """Return (position, velocity, drive, gap) after `duration`.

    options: arguments of scipy's `solve_ivp`
    """
    x, v, drive, gap = (float(value) for value in state[:4])
    u, half, t = limited(p, command), 0.5 * p.backlash, 0.0
    if p.lag == 0.0:
        drive = u
    direction = float(np.sign(v))
    while t < duration:
        if direction == 0.0:
            t, drive, direction = _wait(p, (x, drive), u, gap, half, t, duration, load)
            continue
        engaged = direction * gap >= half
        wall = p.laws.stops[STOPS[direction]]

        def field(_: float, y: Vector, d: float = direction, e: bool = engaged) -> list[float]:
            effort = p.constant * y[2] - opposing(p, load, float(y[0]))
            friction = d * friction_in_slip(p, e, d * float(y[1]))
            return [y[1], (effort - friction) / p.inertia, (u - y[2]) / p.lag if p.lag > 0 else 0.0]

        def stop(_: float, y: Vector, d: float = direction) -> float:
            return d * float(y[1])

        def contact(
            _: float,
            y: Vector,
            d: float = direction,
            x0: float = x,
            g: float = gap,
            e: bool = engaged,
        ) -> float:
            return 1.0 if e else half - d * (g + float(y[0]) - x0)

        def end_stop(_: float, y: Vector, d: float = direction, place: float = wall) -> float:
            return d * (place - float(y[0])) if math.isfinite(place) else 1.0

        events: tuple[Any, ...] = (stop, contact, end_stop)
        for event in events:
            event.terminal, event.direction = True, -1
        scale = np.array([1e-3, max(abs(v), 1.0), max(abs(u), 1.0)])
        absolute = 0.1 * options["rtol"] * scale
        run = solve_ivp(
            field,
            (t, duration),
            [x, v, drive],
            events=events,
            atol=absolute,
            **options,
        )
        t, moved = float(run.t[-1]), float(run.y[0, -1]) - x
        x, v, drive = (float(value) for value in run.y[:, -1])
        gap = gap if engaged else gap + moved
        if run.t_events[0].size:
            v, direction = 0.0, 0.0
        elif run.t_events[1].size:
            gap = direction * half
        elif run.t_events[2].size:
            x, v = wall, -p.laws.restitution * v
            direction = float(np.sign(v))
    return x, v, drive, gap


def _wait(
    p: AxisParameters,
    at: tuple[float, float],
    u: float,
    gap: float,
    half: float,
    t: float,
    end: float,
    load: PositionLoad,
) -> tuple[float, float, float]:
    """Simulate an axis at rest from t to its breakaway or to `end`, by bisection on the drive."""
    x, drive = at
    low_stop, high_stop = p.laws.stops
    forward = math.inf if x >= high_stop else p.breakaway if gap >= half else p.backlash_breakaway
    backward = math.inf if x <= low_stop else p.breakaway if gap <= -half else p.backlash_breakaway

    def drive_at(s: float) -> float:
        return u + (drive - u) * math.exp(-(s - t) / p.lag) if p.lag > 0 else u

    def direction_at(s: float) -> float:
        effort = p.constant * drive_at(s) - opposing(p, load, x)
        return 1.0 if effort > forward else -1.0 if effort < -backward else 0.0

    if direction_at(t) or not direction_at(end):
        direction = direction_at(t)
        return (t if direction else end), drive_at(t if direction else end), direction
    low, high = t, end
    while high - low > 1e-15 * end:
        low, high = (
            (low, 0.5 * (low + high))
            if direction_at(0.5 * (low + high))
            else (0.5 * (low + high), high)
        )
    return high, drive_at(high), direction_at(high)
