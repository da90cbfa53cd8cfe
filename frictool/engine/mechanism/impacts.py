"""Speeds after impacts of backlash flanks, and after impacts on end stops.

An impact occurs between two groups of rigidly joined blocks, or between a group and the frame. It
follows Newton's law of impact with the restitution of the contact. In a row of touching groups, the
impact passes from contact to contact, as in Newton's cradle, until no two groups approach. The
contact with the largest approach speed is resolved first. Friction forces are finite and have no
impulse; an impact can therefore set blocks at rest in motion.

Losses of joints are proportional to the transmitted force and therefore take a fraction of the
impulse (lossy_impulses.py). Even if the losses change during the impact, the flanks return at most
the energy that they absorbed. Approaches slower than BOUNCE have no rebound, so that a series of
rebounds ends at rest.
"""

from __future__ import annotations

import math

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.guard_tolerances import joint_gap, stop_slack
from frictool.engine.mechanism.lossy_impulses import Group, is_group_lossy, yielding
from frictool.engine.mechanism.state import OPEN, RIGID
from frictool.engine.status_codes import OK, UNRESOLVED
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

BOUNCE = 1e-6  # slowest approach with a rebound, relative to the speed scale
TOGETHER = 1e-12  # largest speed difference of touching parts, relative to the speed scale
STANDING = 1e-9  # largest speed of a block that a stop holds, relative to the speed scale
MAX_ROUNDS = 100_000  # largest number of impacts in a call
MAX_PIECES = 20  # largest number of pieces of an impulse (`_meet`)
TOUCHING = 4.0  # largest distance of flanks that touch, in tolerances of position


@bare_kernel
def _approach(k: IntVector, p: Vector, joint: int, side: int, y: Vector) -> float:
    n = k[ly.BLOCKS]
    row = ly.joint_row(k, joint)
    a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
    return float(side * (y[n + b] - ly.ratio(p, row) * y[n + a]))


@bare_kernel
def _set_group(k: IntVector, p: Vector, group: int, speed: float, y: Vector) -> float:
    n = k[ly.BLOCKS]
    before = y[n + group]
    for i in range(n):
        if ly.group_of(k, i) == group:
            y[n + i] = ly.group_ratio(k, p, i) * speed
    return float(0.5 * ly.group_mass(k, p, group) * (before - speed) * (before + speed))


@bare_kernel
def _until(s: float, rate: float, goal: float, absorbed: float) -> float:
    """Return the impulse after which the approach speed s is `goal`; inf if s does not fall.

    For separating flanks, the result is at most the impulse after which the flanks have returned
    all the energy `absorbed`. rate: change of s per unit of impulse.
    """
    if rate >= 0.0:
        return math.inf
    reached = (goal - s) / rate
    if goal == 0.0 and s > 0.0:
        return reached
    return min(reached, (-s - math.sqrt(max(0.0, s * s - 2.0 * rate * absorbed))) / rate)


@part_kernel
def _meet(
    k: IntVector, p: Vector, joint: int, side: int, y: Vector, w: Vector, work: Vector
) -> None:
    n = k[ly.BLOCKS]
    row = ly.joint_row(k, joint)
    ratio = ly.ratio(p, row)
    a, b = ly.joint_a(k, joint), ly.joint_b(k, joint)
    group_a, group_b = ly.group_of(k, a), ly.group_of(k, b)
    along_a = ratio * ly.group_ratio(k, p, a)
    along_b = ly.group_ratio(k, p, b)
    hit_a, hit_b = Group(k, p, group_a, a, w), Group(k, p, group_b, b, w)
    lossy_a, lossy_b = is_group_lossy(k, p, group_a), is_group_lossy(k, p, group_b)
    s = _approach(k, p, joint, side, y)
    # an impulse of the opposite sign gives separating flanks the same speed
    towards = side * math.copysign(1.0, s)
    s = abs(s)
    least = -s * (ly.restitution(p, row) if s > BOUNCE * ly.speed_scale(k, p, b) else 0.0)
    v_a = y[n + group_a]
    v_b = y[n + group_b]
    absorbed = 0.0
    for _ in range(MAX_PIECES):
        x_a = yielding(hit_a, row, -towards, v_a, lossy_a)
        x_b = yielding(hit_b, -1, -towards, v_b, lossy_b)
        if math.isnan(x_a) or math.isnan(x_b):  # a group that wedges stops immediately
            v_a, v_b = 0.0 if math.isnan(x_a) else v_a, 0.0 if math.isnan(x_b) else v_b
            s = towards * (along_b * v_b - along_a * v_a)
            if s <= 0.0:
                break
            continue
        rate = towards * (along_b * x_b - along_a * x_a)
        goal = 0.0 if s > 0.0 else least
        full = _until(s, rate, goal, absorbed)
        rest_a = -v_a / x_a if v_a * x_a < 0.0 else math.inf
        rest_b = -v_b / x_b if v_b * x_b < 0.0 else math.inf
        piece = min(full, rest_a, rest_b)
        if math.isinf(piece):
            break
        v_a = 0.0 if piece == rest_a else v_a + x_a * piece
        v_b = 0.0 if piece == rest_b else v_b + x_b * piece
        absorbed += (s + 0.5 * rate * piece) * piece
        s = goal if piece == full else s + rate * piece
        if piece == full and goal == least:
            break
    if s == 0.0 and v_b == 0.0:
        v_a = 0.0
    elif s == 0.0:
        v_b = along_a * v_a / along_b
    at = k[ly.SOURCES] + n + k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.FRICTIONS] + k[ly.PRESSINGS]
    work[at + joint] += _set_group(k, p, group_a, v_a, y) + _set_group(k, p, group_b, v_b, y)


@bare_kernel
def _strike(
    k: IntVector, p: Vector, stop: int, side: int, y: Vector, w: Vector, work: Vector
) -> None:
    n = k[ly.BLOCKS]
    row = ly.stop_row(k, stop)
    block = ly.stop_block(k, stop)
    group = ly.group_of(k, block)
    speed = side * y[n + block]
    thrown = ly.throw_back(p, row) if speed > BOUNCE * ly.speed_scale(k, p, block) else 0.0
    if thrown > 0.0 and is_group_lossy(k, p, group):
        hit = Group(k, p, group, block, w)
        stopping = yielding(hit, -1, -side, y[n + group], True)
        leaving = yielding(hit, -1, -side, 0.0, True)
        thrown = 0.0 if math.isnan(stopping) else min(thrown, math.sqrt(leaving / stopping))
    after = -thrown * y[n + group] if thrown > 0.0 else 0.0
    at = k[ly.SOURCES] + n + 2 * k[ly.JOINTS] + k[ly.COUPLINGS] + k[ly.FRICTIONS] + k[ly.PRESSINGS]
    work[at + stop] += _set_group(k, p, group, after, y)


@bare_kernel
def _mark(k: IntVector, p: Vector, y: Vector, modes: IntVector) -> None:
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    for joint in range(k[ly.JOINTS]):
        if modes[n + joint] == OPEN:
            e, _, slack = joint_gap(k, p, joint, y)
            gap = ly.gap(p, ly.joint_row(k, joint))
            if abs(e) >= gap - TOUCHING * slack:
                modes[n + joint] = -1 if e < 0.0 else 1
    for s in range(k[ly.STOPS]):
        block, row = ly.stop_block(k, s), ly.stop_row(k, s)
        if modes[stops + s] == OPEN:
            slack = TOUCHING * stop_slack(p, row)
            if y[block] <= ly.low(p, row) + slack:
                modes[stops + s] = -1
            elif y[block] >= ly.high(p, row) - slack:
                modes[stops + s] = 1


@bare_kernel
def _let_go(k: IntVector, p: Vector, y: Vector, modes: IntVector, speed: float) -> None:
    n = k[ly.BLOCKS]
    for joint in range(k[ly.JOINTS]):
        if modes[n + joint] not in (OPEN, RIGID):
            b = ly.joint_b(k, joint)
            if _approach(k, p, joint, modes[n + joint], y) < -speed * ly.speed_scale(k, p, b):
                modes[n + joint] = OPEN


@bare_kernel
def _part(k: IntVector, p: Vector, y: Vector, modes: IntVector) -> None:
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    _let_go(k, p, y, modes, TOGETHER)
    for s in range(k[ly.STOPS]):
        block = ly.stop_block(k, s)
        if modes[stops + s] != OPEN and abs(y[n + block]) > STANDING * ly.speed_scale(k, p, block):
            modes[stops + s] = OPEN


@bare_kernel
def _fastest(k: IntVector, p: Vector, y: Vector, modes: IntVector, soft: bool) -> tuple[float, int]:
    """Return (largest approach speed of all contacts, index of the contact with this speed).

    Approach speeds are relative to the block's speed scale. The index of a contact is the index of
    its joint, or the number of joints plus the index of its stop; it is -1 if no contact
    approaches. If `soft` is True, touching flanks that separate count as approaching.
    """
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
    worst = TOGETHER
    which = -1
    for joint in range(k[ly.JOINTS]):
        side = modes[n + joint]
        if side not in (OPEN, RIGID):
            speed = _approach(k, p, joint, side, y) / ly.speed_scale(k, p, ly.joint_b(k, joint))
            speed = abs(speed) if soft else speed
            if speed > worst:
                worst, which = speed, joint
    for s in range(k[ly.STOPS]):
        if modes[stops + s] != OPEN:
            block = ly.stop_block(k, s)
            speed = modes[stops + s] * y[n + block] / ly.speed_scale(k, p, block)
            if speed > worst:
                worst = speed
                which = k[ly.JOINTS] + s
    return worst, which


@part_kernel
def impacts(k: IntVector, p: Vector, y: Vector, modes: IntVector, w: Vector, work: Vector) -> int:
    """Close touching contacts, resolve all impacts, and open separating contacts.

    The energy lost in each contact is added to `work`. If all approach speeds are below BOUNCE,
    touching blocks get the same speed, and the forces then determine which contacts stay closed.
    This prevents an endless series of impacts if two blocks alternately push a third block. Returns
    a status of engine/status_codes.py.
    """
    n = k[ly.BLOCKS]
    stops = k[ly.BLOCKS] + 2 * k[ly.JOINTS] + k[ly.COUPLINGS]
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
        if which < k[ly.JOINTS]:
            _meet(k, p, which, modes[n + which], y, w, work)
        else:
            _strike(k, p, which - k[ly.JOINTS], modes[stops + which - k[ly.JOINTS]], y, w, work)
    return UNRESOLVED
