"""Weak-form rows along a stream of samples, summed to one Gram matrix per move.

    sample k   friction, bends and falls at k, written to a ring buffer if the sample is used
    row        sums over the window that ends at k: phi times the ring buffer, phi'' times the
               positions; computed once per `every` used samples
    move       sum of row' row

The bends and falls of a sample are the regressors (|v| - knee_j)+ and exp(-(v/w_j)^n) of
`weak_form_layout.py`.

A sample is used if the axis moves in one direction, faster than `slowest`, during the `reach`
samples before and after it. The load must be attached (backlash closed), and the axis away from
the end stops. The load is attached as soon as the axis has moved in one direction by the widest
possible backlash. Before that, the position inside the backlash is unknown, and no sample is used.

A move ends after REST windows below the speed `slowest`, at a reversal, or after MOST_ROWS rows.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.observe.kernels.friction_interval import dry_friction
from frictool.plant.axis_friction_laws import STRIBECK_EXPONENT
from frictool.plant.position_load import load_effort
from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector

MOST_ROWS = 400.0  # largest number of rows of a move
REST = 1.0  # number of windows below the speed `slowest` after which a move has ended

# indices of `numbers`, the kernel's constants, from weak_form_layout.py
PERIOD, SLOWEST, FASTEST, GAP, LOW_STOP, HIGH_STOP, OFFSET, HALF_COUNT = range(8)
# indices of `state`: least and largest possible position inside the backlash, number and direction
# of successive usable samples, number of samples since a usable one, number of all samples
PLAY_LOW, PLAY_HIGH, RUN, DIRECTION, IDLE, SEEN = range(6)
STATE_SIZE = 6
# indices of `move`: number of rows, direction, sum of the rows' speeds, last sample of the last
# row, 1 if the move has ended
ROWS, SIDE, SPEEDS, LAST, ENDED = range(5)
MOVE_SIZE = 5


@kernel
def attached(state: Vector, step: float, gap: float) -> float:
    """Update the position inside the backlash after the motor has moved by `step` [rad | m].

    Return 1 or -1 if the motor certainly moves the load forward or backward, else 0.
    """
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
    """Return the direction (1 or -1) in which axis and load certainly slip at sample k, else 0.

    The displacements over `reach` samples before and after k must have one direction; their mean
    speeds must be between SLOWEST and FASTEST. In the direction `carried`, the axis is in contact
    with the load.
    """
    before = position[k] - position[k - reach]
    after = position[k + reach] - position[k]
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
    index: int,
    window: int,
    x: float,
    speed: float,
    side: int,
    knees: Vector,
    falls: Vector,
    edges: Vector,
    axis: Vector,
    viscous_factor: float,
    dry_factor: float,
) -> None:
    """Write the regressors of a sample (bends, falls and friction) into the ring buffer.

    The values are written to the columns `index` and `index` + window, so that each window is
    contiguous. The factors of viscous and dry friction are valid at the temperature of the sample.
    `ring` is the ring buffer (h + m + z, 2 window): h rows of bends, m rows of falls, z rows of
    zones. The row of the zone of x [rad | m] gets the friction at x [N m | N], the other zones get
    0. `axis` (EXTENDED_SIZE,) contains the parameters of the axis.
    """
    bends = knees.shape[0]
    other = bends + falls.shape[0]
    zones = edges.shape[0] - 1
    friction = dry_factor * max(0.0, dry_friction(axis, x, 2.0 * side - 1.0, speed))
    zone = 0
    while zone < zones - 1 and x >= edges[zone + 1]:
        zone += 1
    for j in range(bends):
        ring[j, index] = ring[j, index + window] = viscous_factor * max(speed - knees[j], 0.0)
    for j in range(falls.shape[0]):
        fall = dry_factor * math.exp(-((speed / falls[j]) ** axis[STRIBECK_EXPONENT]))
        ring[bends + j, index] = ring[bends + j, index + window] = fall
    for j in range(zones):
        ring[other + j, index] = ring[other + j, index + window] = friction if j == zone else 0.0


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
    warm: Matrix,
) -> None:
    """Fill the row (p + 1,) of the window that ends at sample `last`.

    The last element of the row is the effort.

    - first: column of the ring buffer at which the window begins
    - warm: factors of viscous and dry friction at the temperatures of the samples, (2, n)
    """
    window = phi.shape[0]
    over_speed = ring.shape[0] - zones
    start = last - window + 1
    sign = 2.0 * side - 1.0
    origin = position[last]
    row[:] = 0.0
    acceleration = velocity = driven = rising = 0.0
    for j in range(window):
        k = start + j
        acceleration += second[j] * (position[k] - origin)
        if phi[j] > 0.0:
            velocity += phi[j] * warm[0, k] * (position[k + 1] - position[k - 1])
            mean_effort = (
                weights[0] * effort[k - 1] + weights[1] * effort[k] + weights[2] * effort[k + 1]
            )
            rising += phi[j] * (effort[k + 1] - effort[k - 1])
            driven += phi[j] * (mean_effort - load_effort(load, position[k] + numbers[HALF_COUNT]))
    row[0] = acceleration
    row[1] = velocity / (2.0 * numbers[PERIOD])
    for j in range(over_speed + zones):
        total = 0.0
        for i in range(window):
            total += phi[i] * ring[j, first + i]
        index = 2 + j if j < over_speed else 2 + j + side * zones
        row[index] = sign * total
    row[2 + over_speed + 2 * zones + side] = sign
    row[row.shape[0] - 3] = sign * row[1]
    row[row.shape[0] - 2] = rising / (2.0 * numbers[PERIOD])
    row[row.shape[0] - 1] = driven - numbers[OFFSET]


@kernel
def add_row(gram: Vector, row: Vector) -> None:
    """Add row' row to the lower triangle of gram (p + 1, p + 1); zero entries are skipped."""
    for i in range(row.shape[0]):
        if row[i] != 0.0:
            for j in range(i + 1):
                gram[i, j] += row[i] * row[j]


@kernel
def forget(state: Vector, gap: float) -> None:
    """Reset the state after a gap in time; the position inside the backlash is then unknown."""
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
    falls: Vector,
    edges: Vector,
    axis: Vector,
    load: Vector,
    numbers: Vector,
    warm: Matrix,
) -> int:
    """Process samples from `begin` until a move has ended or fewer than `reach` samples remain.

    - position, effort: (n,), with at least window + reach samples before `begin` (fields of
      WeakFormLayout)
    - gram: sum of row' row of the current move, (p + 1, p + 1)
    - move: numbers of the current move, in the order of the module's constants, (5,)
    - warm: factors of viscous and dry friction at the temperature of each sample, (2, n)

    Return the index of the next sample to process; move[ENDED] is 1 if the move has ended.
    """
    window = phi.shape[0]
    zones = edges.shape[0] - 1
    n = position.shape[0]
    row = np.empty(gram.shape[0])
    half = numbers[HALF_COUNT]
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
        index = int(state[SEEN]) % window
        side = 1 if direction > 0.0 else 0
        speed = abs(position[k + reach] - position[k - reach]) / (2.0 * reach * numbers[PERIOD])
        remember(
            ring,
            index,
            window,
            position[k] + half,
            speed,
            side,
            knees,
            falls,
            edges,
            axis,
            warm[0, k],
            warm[1, k],
        )
        ready = state[RUN] - window
        if ready >= 0.0 and ready % every == 0.0:
            fill_row(
                row,
                position,
                effort,
                k,
                ring,
                index + 1,
                side,
                zones,
                phi,
                second,
                weights,
                load,
                numbers,
                warm,
            )
            if move[ROWS] == 0.0:
                move[SIDE] = direction
            add_row(gram, row)
            move[ROWS] += 1.0
            move[SPEEDS] += speed
            move[LAST] = state[SEEN]
        # at a reversal, this is the first sample of the next move, which has no row yet
        if move[ROWS] >= MOST_ROWS or (move[ROWS] > 0.0 and direction != move[SIDE]):
            move[ENDED] = 1.0
            return k + 1
    done: int = max(n - reach, begin)
    return done
