"""The test by which a reduction is checked: a command over time from rest at several places, the
same for every mechanism of the chain.

From five places of the travel, in either direction: a step beyond the breakaway that moves an
eighth of the travel, a rest, a ramp until it breaks away and slips, a rest, and the same step back;
so that a play opens and closes, and friction of both directions counts. Commands are held over a
sample, in the drive's unit. Where friction fades along a step it is left out: where it comes to
rest there is a quotient of two small numbers, and tells nothing of the mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.reduce.one_inertia import OneInertia

Vector = NDArray[np.float64]

PLACES = (0.15, 0.325, 0.5, 0.675, 0.85)  # of the travel
PART = 0.125  # of the travel that a step moves
BEYOND = 1.6  # times the breakaway
RAMP_S, SLIP = 0.3, 1.15  # s to the end of a ramp, times the breakaway there
REST_S = 0.1
LONGEST_S = 4.0  # of one move
LITTLE = 0.02  # of the push: friction below does not stop what moves
STEPS = 101
SLOWEST = 1e-12  # of the largest speed: below it stands
BEYOND_END, FAINT = 1.25, 0.25  # of the way; of the mean friction
FREE = 0.3  # of the drive's limit, where there is no friction to go beyond


@dataclass(frozen=True)
class CheckRun:
    """One command (n,) [unit of the drive] from rest at `place` (of the coordinate of the reduced
    mechanism)."""

    name: str
    place: float
    command: Vector


def runs(one: OneInertia, constant: float, limit: float, period: float) -> tuple[CheckRun, ...]:
    """Of a reduced mechanism; constant [effort per unit of the drive], limit [unit of the drive],
    period [s]."""
    low, high = one.travel if one.travel is not None else one.ends
    found = []
    for share in PLACES:
        place = low + share * (high - low)
        for direction, name in ((1.0, "forward"), (-1.0, "backward")):
            command = _command(one, place, direction, constant, limit, period)
            if command.size:
                found.append(CheckRun(f"{name} from {place:.4g}", place, command))
    return tuple(found)


def _command(
    one: OneInertia, place: float, direction: float, constant: float, limit: float, period: float
) -> Vector:
    most, way = limit * constant, PART * _span(one)
    parts, here = [], place
    for side in (direction, -direction):
        along = here + side * np.linspace(0.0, way, STEPS)
        slip, rest = _resisting(one, along, side)
        needed = BEYOND * max(float(np.max(rest)), 0.0)
        push = min(
            max(
                needed,
                min(FREE * most, one.inertia * _fast(one)) if needed <= LITTLE * most else 0.0,
            ),
            most,
        )
        if _fades(one, here, side, way):
            break
        seconds, brakes = _push_time(one, push, slip, way)
        moving = _held(side * push, seconds, period)
        stop = _held(-side * push, seconds, period) if brakes else np.empty(0)
        coast = _held(
            0.0,
            min(LONGEST_S, 0.0 if brakes else 2.0 * seconds * push / float(np.mean(slip))) + REST_S,
            period,
        )
        broken = float(_resisting(one, along[-1:], side)[1][0])
        ramp = side * np.linspace(
            0.0, min(SLIP * max(broken, 0.0), most), max(2, round(RAMP_S / period))
        )
        parts += [moving, stop, coast, ramp, _held(0.0, REST_S, period)]
        here = float(along[-1])
    return np.concatenate(parts) / constant if parts else np.empty(0)


def _fades(one: OneInertia, place: float, direction: float, way: float) -> bool:
    """Whether friction that brakes at first falls to little before, or just beyond, the end of the
    way."""
    slip, _ = _resisting(
        one, place + direction * np.linspace(0.0, BEYOND_END * way, STEPS), direction
    )
    return bool(0.0 <= np.min(slip) < FAINT * np.mean(slip))


def _span(one: OneInertia) -> float:
    low, high = one.travel if one.travel is not None else one.ends
    return high - low


def _fast(one: OneInertia) -> float:
    """An acceleration that makes an eighth of the travel in a fifth of a second."""
    return 2.0 * PART * _span(one) / 0.2**2


def _resisting(one: OneInertia, places: Vector, direction: float) -> tuple[Vector, Vector]:
    """Friction and breakaway that oppose a motion at places (n,), with the load."""
    side = one.forward if direction > 0.0 else one.backward
    load = direction * one.beside.at(places)
    slip, rest = (np.interp(places, one.positions, curve) for curve in (side.curve, side.breakaway))
    return slip + load, rest + load


def _push_time(one: OneInertia, push: float, slip: Vector, way: float) -> tuple[float, bool]:
    """How long to push [s] so that it comes to rest after `way`, and whether it needs a brake for
    that.

    By work: what the push does over its part of the way is what `slip` (n,), evenly over the way,
    takes of all of it.
    """
    taken = float(np.mean(slip)) * way
    brakes = taken <= LITTLE * push * way
    part = 0.5 * way if brakes else min(way, taken / push)
    x = np.linspace(0.0, part, STEPS) ** 2 / max(part, 1e-300)  # dense where it is slow
    left = push - np.interp(x, np.linspace(0.0, way, len(slip)), slip)
    energy = np.concatenate([[0.0], np.cumsum(0.5 * (left[1:] + left[:-1]) * np.diff(x))])
    speed = np.sqrt(2.0 * np.maximum(energy, 0.0) / one.inertia)
    between = 0.5 * (speed[1:] + speed[:-1])
    moving = between > SLOWEST * float(
        np.max(speed)
    )  # a load may be more than the push from somewhere on
    if not np.any(moving):
        return RAMP_S, brakes
    return min(LONGEST_S, float(np.sum(np.diff(x)[moving] / between[moving]))), brakes


def _held(value: float, seconds: float, period: float) -> Vector:
    return np.full(max(1, round(seconds / period)), value)
