"""Shortest step response of an axis with a limited drive: a lower bound for every controller.

    lag e' = u - e,  |u| <= E         effort e, commanded effort u, effort E at the drive's limit
    J v' = e - viscous v - F,  x' = v     motion towards the target; F = coulomb also when braking

The step starts at rest at x = 0 with e = 0. The response time is the time at which the axis passes
`arrival`; the axis must be able to stop at `farthest` or before. The optimum is u = +E up to one
switching time, then u = -E. Proof: let h(t) be the position's response to an impulse of effort. h
is log-concave, so that h(t_arrival - t)/h(t_rest - t) decreases with t. The command that maximises
x(t_arrival) for a given x(t_rest) therefore changes its sign once, from + to -. Either the axis
stops exactly at `farthest`, or it passes `arrival` before a switch is necessary.

The result is a lower bound, because friction and drive may be unable to keep the axis in the zone
after the stop. If the backlash is open when the step begins, the smaller friction
`backlash_coulomb` acts over the first distance `backlash`. The drive is then assumed to start with
the effort E, which also gives a lower bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from frictool.plant.root_search import sign_change

ZONE = 0.05  # half width of the zone of the response time, relative to the step
NEARLY_EQUAL = 1e-4  # difference of two exponents below which a derivative replaces a quotient
SAMPLE_ROUNDING = 1e-9  # tolerance of a time, relative to the sample period


@dataclass(frozen=True)
class DrivenAxis:
    """Axis with a limited drive, SI, rotary | linear.

    - inertia: kg m^2 | kg
    - viscous: N m s/rad | N s/m
    - coulomb: N m | N
    - effort: largest effort of the drive, N m | N
    - lag: time constant of the drive, s
    - backlash: part of the step that lies inside an open backlash, rad | m
    - backlash_coulomb: Coulomb friction inside the backlash, N m | N
    """

    inertia: float
    viscous: float
    coulomb: float
    effort: float
    lag: float = 0.0
    backlash: float = 0.0
    backlash_coulomb: float = 0.0

    def friction(self, position: float) -> float:
        """Return the Coulomb friction at a position [rad | m] of the step."""
        return self.backlash_coulomb if position < self.backlash else self.coulomb


class StepZone(NamedTuple):
    """Zone of a step that starts at 0: first and last permitted position, rad | m."""

    arrival: float
    farthest: float


def step_zone(length: float, resolution: float, overshoot: float | None = None) -> StepZone:
    """Return the zone in which a step counts as settled to 95 %.

    Parameters
    ----------
    length
        Length of the step, rad | m.
    resolution
        Resolution of the position sensor, rad | m. The half width of the zone and the permitted
        overshoot are at least this value.
    overshoot
        Permitted overshoot relative to `length`; None for no requirement on the overshoot.

    Returns
    -------
    StepZone
        The target ± 5 % of `length`; beyond the target, at most the permitted overshoot.
    """
    zone = max(ZONE * length, resolution)
    beyond = zone if overshoot is None else min(zone, max(overshoot * length, resolution))
    return StepZone(length - zone, length + beyond)


def time_optimal_response(axis: DrivenAxis, zone: StepZone, period: float, delay: int) -> float:
    """Return a lower bound of the response time [s] for every sampled controller.

    Parameters
    ----------
    zone
        Zone that the axis must enter without leaving it again.
    period
        Sample period, s. The response time is a multiple of this period.
    delay
        Computational delay of the command in samples.

    Returns
    -------
    float
        Time from the step to the first sample in the zone; infinite if the drive does not overcome
        the friction.
    """
    samples = delay + shortest_time(axis, zone) / period
    return math.ceil(samples - SAMPLE_ROUNDING) * period if math.isfinite(samples) else math.inf


def shortest_time(axis: DrivenAxis, zone: StepZone) -> float:
    """Return the shortest time [s] from the first command to `zone.arrival`.

    If `zone.farthest` is infinite, the axis need not stop. The time is infinite if the drive does
    not overcome the friction.
    """
    if zone.arrival <= 0.0:
        return 0.0
    if axis.effort <= max(axis.coulomb, axis.friction(0.0)):
        return math.inf
    driven = _driven(axis, zone.arrival)
    end = driven[-1].end

    def farthest(switch: float) -> float:
        braked = _braked(axis, _point_at(axis, driven, switch))
        return braked[-1].end.state.position - zone.farthest

    if farthest(end.time) <= 0.0:
        return end.time
    switch = sign_change(farthest, driven[0].start.time, end.time)
    return _passage(axis, _braked(axis, _point_at(axis, driven, switch)), zone.arrival)


class _State(NamedTuple):
    position: float
    velocity: float
    effort: float


class _Point(NamedTuple):
    time: float
    state: _State


class _Part(NamedTuple):
    start: _Point
    command: float
    end: _Point


def _driven(axis: DrivenAxis, position: float) -> list[_Part]:
    overcome = max(axis.coulomb, 0.0)
    waiting = -axis.lag * math.log1p(-overcome / axis.effort)
    at_once = axis.backlash > 0.0 or axis.lag == 0.0
    start = (
        _Point(0.0, _State(0.0, 0.0, axis.effort))
        if at_once
        else _Point(waiting, _State(0.0, 0.0, overcome))
    )
    parts = []
    for end in (*((axis.backlash,) if 0.0 < axis.backlash < position else ()), position):
        scale = math.sqrt(end * axis.inertia / (axis.effort - axis.coulomb)) + axis.lag
        parts.append(_until(axis, start, axis.effort, partial(_ahead, end), scale))
        start = parts[-1].end._replace(state=parts[-1].end.state._replace(position=end))
    return parts


def _braked(axis: DrivenAxis, start: _Point) -> list[_Part]:
    scale = start.state.velocity * axis.inertia / axis.effort + axis.lag
    part = _until(axis, start, -axis.effort, lambda state: -state.velocity, scale)
    edge = axis.backlash
    if not start.state.position < edge < part.end.state.position:
        return [part]
    time = _passage(axis, [part], edge)
    state = _advanced(axis, start.state, -axis.effort, time - start.time)
    crossing = _Point(time, state._replace(position=edge))
    return [part._replace(end=crossing), *_braked(axis, crossing)]


def _until(
    axis: DrivenAxis,
    start: _Point,
    command: float,
    value: Callable[[_State], float],
    scale: float,
) -> _Part:
    """Return the motion from `start` until the function `value` of the state reaches 0.

    `scale`: expected duration [s].
    """

    def after(span: float) -> float:
        return value(_advanced(axis, start.state, command, span))

    if after(0.0) >= 0.0:
        return _Part(start, command, start)
    longest = scale
    while after(longest) < 0.0:
        longest *= 2.0
    span = sign_change(after, 0.0, longest)
    end = _Point(start.time + span, _advanced(axis, start.state, command, span))
    return _Part(start, command, end)


def _point_at(axis: DrivenAxis, parts: list[_Part], time: float) -> _Point:
    part = next((part for part in parts if time <= part.end.time), parts[-1])
    span = time - part.start.time
    return _Point(time, _advanced(axis, part.start.state, part.command, span))


def _passage(axis: DrivenAxis, parts: list[_Part], position: float) -> float:
    start, command, end = next(
        (part for part in parts if part.end.state.position >= position), parts[-1]
    )

    def ahead(time: float) -> float:
        return _ahead(position, _advanced(axis, start.state, command, time - start.time))

    if ahead(start.time) >= 0.0:
        return start.time
    return sign_change(ahead, start.time, end.time)


def _ahead(position: float, state: _State) -> float:
    return state.position - position


def _advanced(axis: DrivenAxis, start: _State, command: float, time: float) -> _State:
    effort = start.effort if axis.lag > 0.0 else command
    damped = axis.viscous / axis.inertia * time
    lagged = time / axis.lag if axis.lag > 0.0 else math.inf
    constant = (command - axis.friction(start.position)) / axis.inertia
    decaying = (effort - command) / axis.inertia
    velocity = start.velocity * math.exp(-damped) + time * (
        constant * _mean(damped)
        + (decaying * math.exp(-min(damped, lagged)) * _mean(abs(lagged - damped)))
    )
    position = (
        start.position
        + start.velocity * time * _mean(damped)
        + time**2 * (constant * _second(0.0, damped) + decaying * _second(damped, lagged))
    )
    return _State(position, velocity, command + (effort - command) * math.exp(-lagged))


def _mean(exponent: float) -> float:
    if exponent == 0.0:
        return 1.0
    return -math.expm1(-exponent) / exponent


def _second(first: float, second: float) -> float:
    if math.isinf(second):
        return 0.0
    if abs(second - first) > NEARLY_EQUAL * (1.0 + second):
        return (_mean(first) - _mean(second)) / (second - first)
    middle = 0.5 * (first + second)
    if middle < NEARLY_EQUAL:
        return 0.5 - middle / 3.0
    return (_mean(middle) - math.exp(-middle)) / middle
