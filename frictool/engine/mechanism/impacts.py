"""Flanks that meet, where the play of (2.18) is taken up, and end stops: velocities after an
impact, from which on (2.19) holds.

An impact is between two groups of rigidly joined blocks, or a group and the frame, by Newton's law
with the contact's restitution. Where groups touch in a row, it passes from contact to contact, the
fastest approach first, as through the balls of Newton's cradle, until no two approach. Friction of
blocks is finite and takes no impulse; what rests is freed. Losses of joints are parts of what they
pass and take theirs (lossy_impulses.py); where they change within the shock, the flanks give back
no more energy than they took, whatever the restitution. Approaches below BOUNCE of the speed that
counts are not thrown back: a bouncing that would go on without end rests.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.compiled_mechanism import (
    BLOCKS,
    COUPLINGS,
    FRICTIONS,
    GAP,
    GROUP,
    GROUP_MASS,
    GROUP_RATIO,
    HIGH,
    JOINT_ENDS,
    JOINTS,
    LOW,
    PRESSINGS,
    RATIO,
    RESTITUTION,
    SOURCES,
    SPEED,
    STOP,
    STOP_BLOCKS,
    STOP_WIDTH,
    STOPS,
    THROW_BACK,
)
from frictool.engine.mechanism.guard_tolerances import joint_gap, stop_slack
from frictool.engine.mechanism.joint_losses import joint_row
from frictool.engine.mechanism.lossy_impulses import is_group_lossy, yielding
from frictool.engine.mechanism.state import OPEN, RIGID
from frictool.engine.status import OK, UNRESOLVED
from frictool.runtime.kernels import inset_kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

BOUNCE = 1e-6  # of the speed that counts
TOGETHER = 1e-12
STANDING = 1e-9  # of the speed that counts: slower than that a stop holds
MAX_ROUNDS = 100_000
MAX_PIECES = 20  # of one impulse
TOUCHING = 4.0  # margins: flanks that are nearer than this many touch


@inset_kernel
def _approach(k: Places, p: Vector, joint: int, side: int, y: Vector) -> float:
    """Speed at which the flanks of a side approach, at b."""
    n, row = k[BLOCKS], joint_row(k, joint)
    a, b = k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1]
    return float(side * (y[n + b] - p[row + RATIO] * y[n + a]))


@inset_kernel
def _set_group(k: Places, p: Vector, group: int, speed: float, y: Vector) -> float:
    """Gives a group the speed of its first block; returns the energy that it loses by it [J]."""
    n = k[BLOCKS]
    before = y[n + group]
    for i in range(n):
        if k[k[GROUP] + i] == group:
            y[n + i] = p[k[GROUP_RATIO] + i] * speed
    return float(0.5 * p[k[GROUP_MASS] + group] * (before - speed) * (before + speed))


@inset_kernel
def _until(s: float, rate: float, goal: float, given: float) -> float:
    """The impulse at which the approach s reaches `goal`, or at which flanks that part have
    returned what they took, `given`."""
    if rate >= 0.0:
        return math.inf
    reached = (goal - s) / rate
    if goal == 0.0 and s > 0.0:
        return reached
    return min(reached, (-s - math.sqrt(max(0.0, s * s - 2.0 * rate * given))) / rate)


@part_kernel
def _meet(k: Places, p: Vector, joint: int, side: int, y: Vector, w: Vector, work: Vector) -> None:
    """One impact of two groups: the impulse grows, in pieces between the instants at which one of
    them comes to rest."""
    n, row = k[BLOCKS], joint_row(k, joint)
    a, b, ratio = k[k[JOINT_ENDS] + 2 * joint], k[k[JOINT_ENDS] + 2 * joint + 1], p[row + RATIO]
    group_a, group_b = k[k[GROUP] + a], k[k[GROUP] + b]
    along_a, along_b = ratio * p[k[GROUP_RATIO] + a], p[k[GROUP_RATIO] + b]
    lossy_a, lossy_b = is_group_lossy(k, p, group_a), is_group_lossy(k, p, group_b)
    s = _approach(k, p, joint, side, y)
    towards = side * math.copysign(
        1.0, s
    )  # flanks that are made to move together are also held back
    s = abs(s)
    least = -s * (p[row + RESTITUTION] if s > BOUNCE * p[k[SPEED] + b] else 0.0)
    v_a, v_b, given = y[n + group_a], y[n + group_b], 0.0
    for _ in range(MAX_PIECES):
        x_a = yielding(k, p, group_a, a, row, -towards, v_a, lossy_a, w)
        x_b = yielding(k, p, group_b, b, -1, -towards, v_b, lossy_b, w)
        if math.isnan(x_a) or math.isnan(x_b):  # it wedges, and stops dead
            v_a, v_b = 0.0 if math.isnan(x_a) else v_a, 0.0 if math.isnan(x_b) else v_b
            s = towards * (along_b * v_b - along_a * v_a)
            if s <= 0.0:
                break
            continue
        rate = towards * (along_b * x_b - along_a * x_a)
        goal = 0.0 if s > 0.0 else least
        full = _until(s, rate, goal, given)
        rest_a = -v_a / x_a if v_a * x_a < 0.0 else math.inf
        rest_b = -v_b / x_b if v_b * x_b < 0.0 else math.inf
        piece = min(full, rest_a, rest_b)
        if math.isinf(piece):
            break
        v_a = 0.0 if piece == rest_a else v_a + x_a * piece
        v_b = 0.0 if piece == rest_b else v_b + x_b * piece
        given += (s + 0.5 * rate * piece) * piece
        s = goal if piece == full else s + rate * piece
        if piece == full and goal == least:
            break
    if s == 0.0 and v_b == 0.0:
        v_a = 0.0
    elif s == 0.0:
        v_b = along_a * v_a / along_b
    at = k[SOURCES] + n + k[JOINTS] + k[COUPLINGS] + k[FRICTIONS] + k[PRESSINGS]
    work[at + joint] += _set_group(k, p, group_a, v_a, y) + _set_group(k, p, group_b, v_b, y)


@inset_kernel
def _strike(k: Places, p: Vector, stop: int, side: int, y: Vector, w: Vector, work: Vector) -> None:
    """One impact of a group at an end stop."""
    n, row, block = k[BLOCKS], k[STOP] + stop * STOP_WIDTH, k[k[STOP_BLOCKS] + stop]
    group, speed = k[k[GROUP] + block], side * y[n + block]
    thrown = p[row + THROW_BACK] if speed > BOUNCE * p[k[SPEED] + block] else 0.0
    if thrown > 0.0 and is_group_lossy(k, p, group):
        stopping = yielding(k, p, group, block, -1, -side, y[n + group], True, w)
        leaving = yielding(k, p, group, block, -1, -side, 0.0, True, w)
        thrown = 0.0 if math.isnan(stopping) else min(thrown, math.sqrt(leaving / stopping))
    after = -thrown * y[n + group] if thrown > 0.0 else 0.0
    at = k[SOURCES] + n + 2 * k[JOINTS] + k[COUPLINGS] + k[FRICTIONS] + k[PRESSINGS]
    work[at + stop] += _set_group(k, p, group, after, y)


@inset_kernel
def _mark(k: Places, p: Vector, y: Vector, modes: Places) -> None:
    """Marks flanks and stops that touch."""
    n, stops = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS]
    for joint in range(k[JOINTS]):
        if modes[n + joint] == OPEN:
            e, _, slack = joint_gap(k, p, joint, y)
            gap = p[joint_row(k, joint) + GAP]
            if abs(e) >= gap - TOUCHING * slack:
                modes[n + joint] = -1 if e < 0.0 else 1
    for s in range(k[STOPS]):
        block, row = k[k[STOP_BLOCKS] + s], k[STOP] + s * STOP_WIDTH
        if modes[stops + s] == OPEN:
            slack = TOUCHING * stop_slack(p, row)
            if y[block] <= p[row + LOW] + slack:
                modes[stops + s] = -1
            elif y[block] >= p[row + HIGH] - slack:
                modes[stops + s] = 1


@inset_kernel
def _let_go(k: Places, p: Vector, y: Vector, modes: Places, speed: float) -> None:
    """Opens contacts that separate faster than `speed`, of the speed that counts."""
    n = k[BLOCKS]
    for joint in range(k[JOINTS]):
        if modes[n + joint] not in (OPEN, RIGID):
            b = k[k[JOINT_ENDS] + 2 * joint + 1]
            if _approach(k, p, joint, modes[n + joint], y) < -speed * p[k[SPEED] + b]:
                modes[n + joint] = OPEN


@inset_kernel
def _part(k: Places, p: Vector, y: Vector, modes: Places) -> None:
    """Opens the contacts that separate; the groups of those that stay move together exactly."""
    n, stops = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS]
    _let_go(k, p, y, modes, TOGETHER)
    for s in range(k[STOPS]):
        block = k[k[STOP_BLOCKS] + s]
        if modes[stops + s] != OPEN and abs(y[n + block]) > STANDING * p[k[SPEED] + block]:
            modes[stops + s] = OPEN


@inset_kernel
def _fastest(k: Places, p: Vector, y: Vector, modes: Places, soft: bool) -> tuple[float, int]:
    """The largest approach, of the speed that counts, and whose: a joint, or after the joints a
    stop. soft: or separation."""
    n, stops = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS]
    worst, which = TOGETHER, -1
    for joint in range(k[JOINTS]):
        side = modes[n + joint]
        if side not in (OPEN, RIGID):
            speed = _approach(k, p, joint, side, y) / p[k[SPEED] + k[k[JOINT_ENDS] + 2 * joint + 1]]
            speed = abs(speed) if soft else speed
            if speed > worst:
                worst, which = speed, joint
    for s in range(k[STOPS]):
        if modes[stops + s] != OPEN:
            block = k[k[STOP_BLOCKS] + s]
            speed = modes[stops + s] * y[n + block] / p[k[SPEED] + block]
            if speed > worst:
                worst, which = speed, k[JOINTS] + s
    return worst, which


@part_kernel
def impacts(k: Places, p: Vector, y: Vector, modes: Places, w: Vector, work: Vector) -> int:
    """Marks what touches, resolves all approaches, opens what separates; energy lost goes to
    `work`. Returns engine/status.py.

    Where all approaches are below BOUNCE, what touches comes to move together, and the forces
    decide what stays so: two parts that push a third in turn would else knock at it without end.
    """
    n, stops = k[BLOCKS], k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS]
    _mark(k, p, y, modes)
    worst, _ = _fastest(k, p, y, modes, False)
    soft = worst < BOUNCE
    if soft:
        _let_go(k, p, y, modes, BOUNCE)
    for _ in range(MAX_ROUNDS):
        worst, which = _fastest(k, p, y, modes, soft)
        if which < 0:
            _part(k, p, y, modes)
            return OK
        if which < k[JOINTS]:
            _meet(k, p, which, modes[n + which], y, w, work)
        else:
            _strike(k, p, which - k[JOINTS], modes[stops + which - k[JOINTS]], y, w, work)
    return UNRESOLVED
