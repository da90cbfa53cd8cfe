"""The modes at one instant, until they and the forces agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.ends import forces_hold
from frictool.engine.mechanism.events import JAMS, write
from frictool.engine.mechanism.field import field
from frictool.engine.mechanism.image import (
    BLOCKS,
    COUPLINGS,
    FRICTIONS,
    JOINTS,
    MASS,
    ORDER,
    OUTWARD,
    PARENT,
    PARENT_JOINT,
    PRESSINGS,
    RATIO,
    SOURCES,
    SPAN,
    STOP_BLOCKS,
    STOPS,
)
from frictool.engine.mechanism.resolve import resolve
from frictool.engine.mechanism.state import FIRST_POWER, FOUND, GUARD, INPUTS, OPEN, Room
from frictool.engine.mechanism.transmission import joint_row
from frictool.engine.status import JAMMED, LAW_FAILED, OK, UNRESOLVED
from frictool.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

ATTEMPTS = 50


@inset_kernel
def halt(k: Places, place: int, p: Vector, y: Vector, modes: Places) -> float:
    """Stops the tree whose root is at `place` in the order; returns its energy [J]."""
    n, energy = k[BLOCKS], 0.0
    at, end = place, place + k[k[SPAN] + k[k[ORDER] + place]]
    while at < end:
        i = k[k[ORDER] + at]
        if at > place and modes[n + k[k[PARENT_JOINT] + i]] == OPEN:
            at += k[k[SPAN] + i]
            continue
        energy += 0.5 * p[k[MASS] + i] * y[n + i] * y[n + i]
        y[n + i] = 0.0
        at += 1
    return energy


@inset_kernel
def align(k: Places, p: Vector, y: Vector, modes: Places) -> None:
    """Blocks that move together do so exactly, and what stops hold stands: no rounding grows in the speeds between them."""
    n, stops = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS]
    for s in range(k[STOPS]):
        if modes[stops + s] != OPEN:
            i = k[k[STOP_BLOCKS] + s]
            while k[k[PARENT_JOINT] + i] >= 0 and modes[n + k[k[PARENT_JOINT] + i]] != OPEN:
                i = k[k[PARENT] + i]
            y[n + i] = 0.0
    for place in range(n):
        i = k[k[ORDER] + place]
        joint = k[k[PARENT_JOINT] + i]
        if joint >= 0 and modes[n + joint] != OPEN:
            ratio = p[joint_row(k, joint) + RATIO]
            y[n + i] = y[n + k[k[PARENT] + i]] * (ratio if k[k[OUTWARD] + i] == 1 else 1.0 / ratio)


@inset_kernel
def _jam(k: Places, p: Vector, t: float, place: int, y: Vector, modes: Places, work: Vector, events: Vector, happened: Places) -> bool:
    """A tree that jams stops dead: an impact without a collision. False where it rests already."""
    n, root = k[BLOCKS], k[k[ORDER] + place]
    speed, energy = y[n + root], halt(k, place, p, y, modes)
    if energy == 0.0:
        return False
    # on the joint that leads to the root's first child
    first = k[k[PARENT_JOINT] + k[k[ORDER] + place + 1]]
    work[k[SOURCES] + n + k[JOINTS] + k[COUPLINGS] + k[FRICTIONS] + k[PRESSINGS] + first] += energy
    write(events, happened, t, JAMS, root, speed)
    return True


@part_kernel
def settle(
    k: Places,
    p: Vector,
    laws: Places,
    t: float,
    y: Vector,
    modes: Places,
    room: Room,
    work: Vector,
    now: float,
    events: Vector,
    happened: Places,
) -> int:
    """Finds the modes, and fills room.slopes[0] = y', guard and first_power by them. t: since the command; now: for events.

    Returns engine/status.py.
    """
    inputs, out, w, guard, power, found = (
        room.lines[INPUTS],
        room.slopes[0],
        room.w,
        room.lines[GUARD],
        room.lines[FIRST_POWER],
        room.places[FOUND],
    )
    for _ in range(ATTEMPTS):
        status = resolve(k, p, laws, t, y, modes, inputs, out, w, guard, power, found, work)
        if status == JAMMED:
            if not _jam(k, p, now, found[-1], y, modes, work, events, happened):
                return JAMMED
            continue
        if status != OK:
            return status
        if field(k, p, laws, t, y, modes, inputs, out, w, guard, power) != 0:
            return LAW_FAILED
        if forces_hold(k, modes, guard):
            return OK
    return UNRESOLVED
