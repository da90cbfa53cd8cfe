"""The test by which a reduction is checked: a command over time from rest at several places, the same for every mechanism of the chain.

From five places of the travel, in either direction: a step beyond the breakaway that moves an eighth of the travel, a rest, a ramp until it
breaks away and slips, a rest, and the same step back; so that a play opens and closes, and friction of both directions counts. Commands are
held over a sample, in the drive's unit.
"""

from __future__ import annotations

import math
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
FREE = 0.3  # of the drive's limit, where there is no friction to go beyond


@dataclass(frozen=True)
class Run:
    """One command (n,) [unit of the drive] from rest at `place` (of the coordinate of the reduced mechanism)."""

    name: str
    place: float
    command: Vector


def runs(one: OneInertia, constant: float, limit: float, period: float) -> tuple[Run, ...]:
    """Of a reduced mechanism; constant [effort per unit of the drive], limit [unit of the drive], period [s]."""
    low, high = one.travel if one.travel is not None else one.ends
    found = []
    for share in PLACES:
        place = low + share * (high - low)
        for direction, name in ((1.0, "forward"), (-1.0, "backward")):
            command = _command(one, place, direction, constant, limit, period)
            found.append(Run(f"{name} from {place:.4g}", place, command))
    return tuple(found)


def _command(one: OneInertia, place: float, direction: float, constant: float, limit: float, period: float) -> Vector:
    most = limit * constant
    there, back = (_resisting(one, place, side) for side in (direction, -direction))
    parts = []
    for side, (slip, rest) in ((direction, there), (-direction, back)):
        push = min(BEYOND * max(rest, 0.0), most) if rest > 0.02 * most else FREE * min(most, one.inertia * _fast(one))
        seconds = _push_time(one, push, slip, _span(one) * PART)
        moving = _held(side * push, seconds, period)
        stop = _held(-side * push, seconds, period) if slip <= 0.02 * push else np.empty(0)
        coast = _held(0.0, min(LONGEST_S, 1.5 * seconds * push / slip if slip > 0.02 * push else 0.0) + REST_S, period)
        ramp = side * np.linspace(0.0, min(SLIP * max(rest, 0.0), most), max(2, round(RAMP_S / period)))
        parts += [moving, stop, coast, ramp, _held(0.0, REST_S, period)]
    return np.concatenate(parts) / constant


def _span(one: OneInertia) -> float:
    low, high = one.travel if one.travel is not None else one.ends
    return high - low


def _fast(one: OneInertia) -> float:
    """An acceleration that makes an eighth of the travel in a fifth of a second."""
    return 2.0 * PART * _span(one) / 0.2**2


def _resisting(one: OneInertia, place: float, direction: float) -> tuple[float, float]:
    """Friction and breakaway that oppose a motion there, with the load."""
    side = one.forward if direction > 0.0 else one.backward
    load = direction * (one.offset + one.stiffness * place)
    slip, rest = (float(np.interp(place, one.positions, curve)) for curve in (side.curve, side.breakaway))
    return slip + load, rest + load


def _push_time(one: OneInertia, push: float, slip: float, way: float) -> float:
    """How long to push for the way to be made by the time it has come to rest again: T^2 a (1 + a J/slip)/2, or 2 T^2 a/2 with a brake."""
    rate = max(push - slip, 1e-3 * push) / one.inertia
    stretch = 1.0 + rate * one.inertia / slip if slip > 0.02 * push else 2.0
    return min(LONGEST_S, math.sqrt(2.0 * way / (rate * stretch)))


def _held(value: float, seconds: float, period: float) -> Vector:
    return np.full(max(1, round(seconds / period)), value)
