"""The axis with laws, written down once more: plain Python, scipy's DOP853 phase by phase with its
event functions.

Each phase holds one smooth formula: the direction, the speed's regime, the position's piece and the
load's contact are fixed in it. Nothing is shared with the engine but the parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from frictool.plant.axis import AxisParameters
from frictool.plant.axis_friction_laws import AxisFrictionLevels, FrictionPositionShape

TINY = 1e-12


class Motion(NamedTuple):
    """State of the reference: SI, as plant/axis.py; rested [s]."""

    x: float
    v: float
    drive: float
    gap: float = 0.0
    rested: float = 0.0


def level(
    shape: FrictionPositionShape | None, terms: str, direction: float, value: float, x: float
) -> float:
    """F_c or F_s of one direction at x: the polynomial over its mean (by quadrature), held beyond
    its range."""
    if shape is None:
        return value
    c = getattr(shape, terms)[0 if direction > 0 else 1]
    mean = sum(
        b * (shape.high ** (k + 1) - shape.low ** (k + 1)) / (k + 1) for k, b in enumerate(c)
    ) / (shape.high - shape.low)
    place = min(max(x, shape.low), shape.high)
    return value * sum(b * place**k for k, b in enumerate(c)) / mean


def levels(p: AxisParameters, direction: float) -> AxisFrictionLevels:
    forward = AxisFrictionLevels(p.viscous, p.coulomb, p.breakaway)
    return forward if direction > 0 or p.laws.backward is None else p.laws.backward


def coulomb(p: AxisParameters, direction: float, x: float) -> float:
    return level(p.laws.shape, "coulomb", direction, levels(p, direction).coulomb, x)


def breakaway(p: AxisParameters, direction: float, x: float, rested: float) -> float:
    full, fc = (
        level(p.laws.shape, "breakaway", direction, levels(p, direction).breakaway, x),
        coulomb(p, direction, x),
    )
    if p.laws.rise_time == 0.0 or full == 0.0:
        return full
    fresh = max(p.laws.fresh, fc / full)
    return full * (1.0 - (1.0 - fresh) * p.laws.rise_time / (p.laws.rise_time + rested))


def viscous_force(p: AxisParameters, direction: float, w: float, regime: int) -> float:
    """Viscous friction as a sum over the regimes up to `regime`, the last one extrapolated."""
    slopes = [
        levels(p, direction).viscous,
        *(r.forward if direction > 0 else r.backward for r in p.laws.regimes),
    ]
    knees = [0.0, *(r.knee for r in p.laws.regimes)]
    return sum(slopes[k] * (knees[k + 1] - knees[k]) for k in range(regime)) + slopes[regime] * (
        w - knees[regime]
    )


def drive_at(p: AxisParameters, u: float, start: float, t: float) -> float:
    return u + (start - u) * math.exp(-t / p.lag) if p.lag > 0 else u


def follow(p: AxisParameters, m: Motion, command: float, duration: float) -> Motion:
    """The motion after `duration` [s] under a held command."""
    u = min(max(command, -p.drive_limit), p.drive_limit)
    m, left = m._replace(drive=m.drive if p.lag > 0 else u), duration
    direction = float(np.sign(m.v))
    for _ in range(300):
        if left <= 0.0:
            return m
        if direction == 0.0:
            m, left, direction = _rest(p, m, u, left)
        else:
            m, left, direction = _slip(p, m, u, left, direction)
    raise AssertionError("the reference does not finish")


def _threshold(p: AxisParameters, m: Motion, direction: float, t: float) -> float:
    stop = p.laws.stops[1 if direction > 0 else 0]
    if direction * (stop - m.x) <= 0:
        return math.inf
    if direction * m.gap < 0.5 * p.backlash:
        return p.backlash_breakaway
    return breakaway(p, direction, m.x, m.rested + t)


def _rest(p: AxisParameters, m: Motion, u: float, left: float) -> tuple[Motion, float, float]:
    """Dense sampling of the margin, then bisection."""
    for direction in (1.0, -1.0):

        def margin(t: float, d: float = direction) -> float:
            return d * (p.constant * drive_at(p, u, m.drive, t) - p.offset) - _threshold(p, m, d, t)

        times = np.linspace(0.0, left, 2001)
        over = [k for k, t in enumerate(times) if margin(t) > 0.0]
        if over and over[0] == 0:
            return m, left, direction
        if over:
            t = brentq(margin, times[over[0] - 1], times[over[0]], xtol=1e-16)
            return (
                m._replace(drive=drive_at(p, u, m.drive, t), rested=m.rested + t),
                left - t,
                direction,
            )
    return m._replace(drive=drive_at(p, u, m.drive, left), rested=m.rested + left), 0.0, 0.0


def _slip(
    p: AxisParameters, m: Motion, u: float, left: float, d: float
) -> tuple[Motion, float, float]:
    laws, engaged, w0 = p.laws, d * m.gap >= 0.5 * p.backlash, d * m.v
    regime = sum(w0 >= r.knee for r in laws.regimes)
    edges = [] if laws.shape is None else [laws.shape.low, laws.shape.high]
    if (
        d * (laws.stops[1 if d > 0 else 0] - m.x) <= TINY
    ):  # contact in the backlash and end stop at one place
        return _rebound(p, m, left, d)

    def field(t: float, y: np.ndarray) -> list[float]:
        effort, x = d * (p.constant * drive_at(p, u, m.drive, t) - p.offset), m.x + d * y[0]
        friction = p.backlash_coulomb
        if engaged:
            friction = coulomb(p, d, x) + viscous_force(p, d, y[1], regime)
            if laws.stribeck_velocity > 0:
                drop = breakaway(p, d, x, m.rested) - coulomb(p, d, x)
                friction += drop * math.exp(
                    -((abs(y[1]) / laws.stribeck_velocity) ** laws.stribeck_exponent)
                )
        return [y[1], (effort - friction) / p.inertia]

    events: list[tuple[str, Callable[[float, np.ndarray], float]]] = [("slow", lambda t, y: y[1])]
    if engaged:
        if regime < len(laws.regimes):
            events.append(("faster", lambda t, y: laws.regimes[regime].knee - y[1]))
        if regime > 0:
            events.append(
                ("slower", lambda t, y: y[1] - laws.regimes[regime - 1].knee * (1 - 2.0**-40))
            )
    else:
        events.append(("contact", lambda t, y: 0.5 * p.backlash - d * m.gap - y[0]))
    for place in [laws.stops[1 if d > 0 else 0], *edges]:
        ahead = d * (place - m.x)
        if math.isfinite(ahead) and ahead > 0:
            events.append(
                ("stop" if place in laws.stops else "edge", lambda t, y, ahead=ahead: ahead - y[0])
            )
    for _, event in events:
        event.terminal, event.direction = True, -1
    scale = max(w0, 1e-2 * laws.stribeck_velocity or 1e-3)
    run = solve_ivp(
        field, (0.0, left), [0.0, w0], "DOP853", events=[event for _, event in events], rtol=1e-11,
        atol=1e-12 * scale,
        first_step=min(left, 1e-7), max_step=2e-4,
    )  # fmt: skip
    t, (y, w) = float(run.t[-1]), (float(run.y[0, -1]), float(run.y[1, -1]))
    happened = [name for (name, _), times in zip(events, run.t_events, strict=True) if times.size]
    kind = happened[0] if happened else ""
    gap = m.gap if engaged else m.gap + d * y
    after = Motion(m.x + d * y, d * w, drive_at(p, u, m.drive, t), gap, m.rested)
    remaining = left - t if happened else 0.0
    if kind == "slow":
        return after._replace(v=0.0, rested=0.0), remaining, 0.0
    if kind == "contact":
        return after._replace(gap=d * 0.5 * p.backlash), remaining, d
    if kind in ("faster", "slower"):
        knee = (
            laws.regimes[regime].knee
            if kind == "faster"
            else laws.regimes[regime - 1].knee * (1 - 2.0**-40)
        )
        return after._replace(v=d * knee), remaining, d
    if kind == "stop":
        return _rebound(p, after, remaining, d)
    if kind == "edge":
        nearest = min(edges, key=lambda place: abs(place - after.x))
        return after._replace(x=nearest, v=d * w), remaining, d
    return after, remaining, d


def _rebound(p: AxisParameters, m: Motion, left: float, d: float) -> tuple[Motion, float, float]:
    """Back from the end stop in direction d; to rest where the effort would bring it there again
    within a microsecond."""
    place, back = p.laws.stops[1 if d > 0 else 0], p.laws.restitution * abs(m.v)
    if 2 * back <= d * (p.constant * m.drive - p.offset) / p.inertia * 1e-6:
        back = 0.0
    return (
        m._replace(x=place, v=-d * back, rested=m.rested if back else 0.0),
        left,
        -d if back else 0.0,
    )
