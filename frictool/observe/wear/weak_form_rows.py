"""Rows of the weak form along a stream of samples, summed up move by move as they come: nothing of
the log is kept.

    sample k ──gap, speed before and after──▶ slips with the load attached? ──▶ its friction, its
    bends (ring of one window)
                                                                                     │ every `every`
                                                                                     samples of an
                                                                                     unbroken run
    move: sum of row' row  ◀── row of the window that ends at k: phi over the ring, phi'' over the
    positions

A sample is used where in `reach` samples before it and in `reach` after it the axis went on in one
direction, faster than `slowest`, past the widest gap that the backlash may have and free of the end
stops. The motor is past the gap where a play of that width (4.45), started from either of its ends,
has arrived at the edge: as long as nobody knows where in its backlash the axis began, nothing is
used.

A move ends where the axis has been too slow for REST windows, where it has turned, or with
MOST_ROWS rows of an endless one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.friction.position_polynomial import polynomial
from frictool.plant.position_load import load_effort
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]

MOST_ROWS = 400.0
REST = 1.0  # windows

# numbers, what the kernel is told: layout.py
PERIOD, SLOWEST, FASTEST, GAP, LOW_STOP, HIGH_STOP, MAP_LOW, MAP_HIGH, OFFSET, HALF_COUNT = range(
    10
)
# state, what it keeps from sample to sample: the play's ends, samples in the run, its direction,
# samples since a usable one, those seen
PLAY_LOW, PLAY_HIGH, RUN, DIRECTION, IDLE, SEEN = range(6)
STATE_SIZE = 6
# move: rows, the direction, the sum of rows' speeds, the last row's sample, whether it has ended
ROWS, SIDE, SPEEDS, LAST, ENDED = range(5)
MOVE_SIZE = 5


@kernel
def attached(state: Vector, step: float, gap: float) -> float:
    """Moves the play by a `step` [rad | m] of the motor; 1 or -1 where the load is certain to be
    carried in that direction, else 0."""
    if gap == 0.0:
        return 1.0 if step > 0.0 else -1.0 if step < 0.0 else 0.0
    half = 0.5 * gap
    state[PLAY_LOW] = min(max(state[PLAY_LOW] + step, -half), half)
    state[PLAY_HIGH] = min(max(state[PLAY_HIGH] + step, -half), half)
    if state[PLAY_LOW] >= half:
        return 1.0
    return -1.0 if state[PLAY_HIGH] <= -half else 0.0


@kernel
def slips(position: Vector, k: int, reach: int, carried: float, numbers: Vector) -> float:
    """The direction, 1 or -1, in which sample k slips for certain with the load attached; 0 where
    it does not, or may not."""
    before, after = position[k] - position[k - reach], position[k + reach] - position[k]
    least, most = (
        numbers[SLOWEST] * numbers[PERIOD] * reach,
        numbers[FASTEST] * numbers[PERIOD] * reach,
    )
    direction = 1.0 if before > 0.0 else -1.0
    if (
        direction * before < least
        or direction * after < least
        or direction * before > most
        or direction * after > most
    ):
        return 0.0
    if numbers[GAP] > 0.0 and carried != direction:
        return 0.0
    return direction if numbers[LOW_STOP] <= position[k] <= numbers[HIGH_STOP] else 0.0


@kernel
def remember(
    ring: Vector,
    place: int,
    window: int,
    x: float,
    speed: float,
    side: int,
    knees: Vector,
    edges: Vector,
    dry: Vector,
    numbers: Vector,
) -> None:
    """Writes bends and friction of a sample into column `place` and once more a window later: any
    window is then one piece of the ring.

    ring (h + z, 2 window): bends (h,), friction (z,) [N m | N] in the zone where x [rad | m] is, 0
    in the others.
    """
    bends, zones = knees.shape[0], edges.shape[0] - 1
    here = min(max(x, numbers[MAP_LOW]), numbers[MAP_HIGH])
    friction = max(0.0, polynomial(dry[side], here))
    zone = 0
    while zone < zones - 1 and x >= edges[zone + 1]:
        zone += 1
    for j in range(bends):
        ring[j, place] = ring[j, place + window] = max(speed - knees[j], 0.0)
    for j in range(zones):
        ring[bends + j, place] = ring[bends + j, place + window] = friction if j == zone else 0.0


@kernel
def fill_row(
    row: Vector,
    position: Vector,
    effort: Vector,
    last: int,
    ring: Vector,
    first: int,
    side: int,
    zones: int,
    phi: Vector,
    second: Vector,
    weights: Vector,
    load: Vector,
    numbers: Vector,
) -> None:
    """The row (p + 1,) of the window that ends at sample `last`, the effort at its end; `first`:
    where the window begins in the ring."""
    window, bends = phi.shape[0], ring.shape[0] - zones
    start, sign, origin = last - window + 1, 2.0 * side - 1.0, position[last]
    row[:] = 0.0
    acceleration = velocity = driven = 0.0
    for j in range(window):
        k = start + j
        acceleration += second[j] * (position[k] - origin)
        if phi[j] > 0.0:
            velocity += phi[j] * (position[k + 1] - position[k - 1])
            given = weights[0] * effort[k - 1] + weights[1] * effort[k] + weights[2] * effort[k + 1]
            driven += phi[j] * (given - load_effort(load, position[k] + numbers[HALF_COUNT]))
    row[0], row[1] = acceleration, velocity / (2.0 * numbers[PERIOD])
    for j in range(bends + zones):
        total = 0.0
        for i in range(window):
            total += phi[i] * ring[j, first + i]
        place = 2 + j if j < bends else 2 + j + side * zones
        row[place] = sign * total
    row[2 + bends + 2 * zones + side] = sign
    row[row.shape[0] - 2] = sign * row[1]
    row[row.shape[0] - 1] = driven - numbers[OFFSET]


@kernel
def add_row(gram: Vector, row: Vector) -> None:
    """gram (p + 1, p + 1), its lower triangle: plus row' row; columns that are 0 cost nothing."""
    for i in range(row.shape[0]):
        if row[i] != 0.0:
            for j in range(i + 1):
                gram[i, j] += row[i] * row[j]


@kernel
def forget(state: Vector, gap: float) -> None:
    """After a gap of the log: nobody knows where in its backlash the axis is."""
    state[:] = 0.0
    state[PLAY_LOW], state[PLAY_HIGH] = -0.5 * gap, 0.5 * gap


@kernel
def walk(
    position: Vector,
    effort: Vector,
    begin: int,
    every: int,
    reach: int,
    state: Vector,
    ring: Vector,
    gram: Vector,
    move: Vector,
    phi: Vector,
    second: Vector,
    weights: Vector,
    knees: Vector,
    edges: Vector,
    dry: Vector,
    load: Vector,
    numbers: Vector,
) -> int:
    """Goes on from sample `begin` until a move has ended, or to the last sample that has `reach`
    others behind it.

    position, effort (n,): with at least window + reach samples before `begin`. gram (p + 1, p + 1)
    and move (5,): of the present move. Returns the sample to go on from; move[ENDED] says whether
    the move has ended.
    """
    window, zones, n = phi.shape[0], edges.shape[0] - 1, position.shape[0]
    row, half = np.empty(gram.shape[0]), numbers[HALF_COUNT]
    for k in range(begin, n - reach):
        carried = attached(state, position[k] - position[k - 1], numbers[GAP])
        direction = slips(position, k, reach, carried, numbers)
        state[SEEN] += 1.0
        if direction == 0.0 or direction != state[DIRECTION]:
            state[RUN] = 0.0
        state[DIRECTION] = direction
        if direction == 0.0:
            state[IDLE] += 1.0
            if move[ROWS] > 0.0 and state[IDLE] >= REST * window:
                move[ENDED] = 1.0
                return k + 1
            continue
        state[IDLE] = 0.0
        state[RUN] += 1.0
        place, side = int(state[SEEN]) % window, 1 if direction > 0.0 else 0
        speed = abs(position[k + reach] - position[k - reach]) / (2.0 * reach * numbers[PERIOD])
        remember(ring, place, window, position[k] + half, speed, side, knees, edges, dry, numbers)
        ready = state[RUN] - window
        if ready >= 0.0 and ready % every == 0.0:
            fill_row(
                row,
                position,
                effort,
                k,
                ring,
                place + 1,
                side,
                zones,
                phi,
                second,
                weights,
                load,
                numbers,
            )
            if move[ROWS] == 0.0:
                move[SIDE] = direction
            add_row(gram, row)
            move[ROWS] += 1.0
            move[SPEEDS] += speed
            move[LAST] = state[SEEN]
        if move[ROWS] >= MOST_ROWS or (
            move[ROWS] > 0.0 and direction != move[SIDE]
        ):  # its first sample: no row of it yet
            move[ENDED] = 1.0
            return k + 1
    done: int = max(n - reach, begin)
    return done
