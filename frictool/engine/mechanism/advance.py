"""Moves a mechanism through a time in which its commands are held, from event to event.

    machine = prepare(packed)                   engine/mechanism/image.py, once
    state = rest(packed, machine, start)        engine/mechanism/state.py
    status = advance(*machine, *state, command, external, duration, TOLERANCE, events, happened)

Between events all modes are held and the rates are smooth: steps of order 8 with error control. A step within which a guard is passed is
taken again to the instant at which it is, found to rounding; then the modes are found anew. At rest, where no rate is left and nothing
flows in or out, the rest of the duration costs nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types
from numpy.typing import NDArray

from frictool.engine.mechanism.ends import first_dip, forces_hold, is_broken, way_left
from frictool.engine.mechanism.events import STRIKES, TOUCHES, write, write_changes
from frictool.engine.mechanism.field import field
from frictool.engine.mechanism.image import (
    BLOCKS,
    CONSTANT,
    COUPLINGS,
    INNER,
    JOINTS,
    LAG,
    LIMIT,
    ORDER,
    RESISTANCE,
    SOURCE,
    SOURCE_BLOCKS,
    SOURCE_WIDTH,
    SOURCES,
    STOPS,
    SUPPLY,
    TIMED,
)
from frictool.engine.mechanism.impacts import impacts
from frictool.engine.mechanism.laws import by_address, called
from frictool.engine.mechanism.locate import locate
from frictool.engine.mechanism.memory import first_reversal, remember
from frictool.engine.mechanism.settle import align, halt, settle
from frictool.engine.mechanism.state import AFTER, BEFORE, END, FIRST_POWER, GUARD, INPUTS, OPEN, POWER, SPEEDS, SPENT, STUCK, TRIAL, Room
from frictool.engine.mechanism.step import try_step
from frictool.engine.mechanism.timed import keep, switch
from frictool.engine.status import LAW_FAILED, NOT_FINITE, OK, STEP_TOO_SMALL, TOO_MANY_EVENTS
from frictool.kernels import inset_kernel, kernel, part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

TOLERANCE = 1e-8  # of a block's speed, and of a tenth of the speed that counts
MAX_EVENTS = 200_000  # in one call
FIRST_STEP = 1e-5  # s
GROWTH, SHRINKAGE, SAFETY = 4.0, 0.2, 0.9
MANY_LAGS = 50.0  # half lags after which nothing is left of what flowed
SHORTEST = 1e-15  # of the time reached, or in s


@inset_kernel
def _commanded(k: Places, p: Vector, command: Vector, external: Vector, y: Vector, drive: Vector, inputs: Vector) -> None:
    """inputs: commands within the drives' limits and the windings' at the speeds of the beginning, what flows, efforts held on blocks."""
    n, u = k[BLOCKS], k[SOURCES]
    for s in range(u):
        row, speed = k[SOURCE] + s * SOURCE_WIDTH, y[n + k[k[SOURCE_BLOCKS] + s]]
        low, high = -p[row + LIMIT], p[row + LIMIT]
        if p[row + RESISTANCE] > 0.0:
            back = p[row + CONSTANT] * speed
            low = max(low, (-p[row + SUPPLY] - back) / p[row + RESISTANCE])
            high = min(high, (p[row + SUPPLY] - back) / p[row + RESISTANCE])
        inputs[s] = min(max(command[s], low), high)
        inputs[u + s] = min(max(drive[s], low), high) if p[row + LAG] > 0.0 else inputs[s]
    for i in range(n):
        inputs[2 * u + i] = external[i]


@inset_kernel
def _are_finite(values: Vector) -> bool:
    total = 0.0
    for value in values:
        total += value
    return math.isfinite(total)


@inset_kernel
def _flows(k: Places, p: Vector, inputs: Vector, t: float, drive: Vector) -> None:
    """What flows in each source t after its command."""
    u = k[SOURCES]
    for s in range(u):
        lag = p[k[SOURCE] + s * SOURCE_WIDTH + LAG]
        drive[s] = inputs[s] if lag == 0.0 else inputs[s] + (inputs[u + s] - inputs[s]) * math.exp(-t / lag)


@inset_kernel
def _longest(k: Places, p: Vector, inputs: Vector) -> float:
    """The longest step in which what flows is as good as a polynomial."""
    u, longest = k[SOURCES], math.inf
    for s in range(u):
        lag = p[k[SOURCE] + s * SOURCE_WIDTH + LAG]
        if lag > 0.0 and inputs[s] != inputs[u + s]:
            longest = min(longest, 0.5 * lag)
    return longest


@inset_kernel
def _is_settled(k: Places, y: Vector, out: Vector, inputs: Vector) -> bool:
    """Whether nothing moves and nothing will until the command changes."""
    n, u = k[BLOCKS], k[SOURCES]
    for s in range(u):
        if inputs[s] != inputs[u + s]:
            return False
    for i in range(n, 2 * n):
        if y[i] != 0.0 or out[i] != 0.0:
            return False
    return bool(k[INNER] == 0 and k[TIMED] == 0)


@inset_kernel
def _happen(k: Places, p: Vector, now: float, y: Vector, modes: Places, guard: Vector, events: Vector, happened: Places) -> bool:
    """Roots whose speed has come to 0 stop with all that moves along; says whether flanks or stops meet."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    meet = False
    for joint in range(j):
        if modes[n + joint] == OPEN and guard[n + joint] <= 0.0:
            _, rate = way_left(k, p, n + joint, y, y, modes)
            if rate < 0.0:
                write(events, happened, now, TOUCHES, joint, -rate)
                meet = True
    for s in range(k[STOPS]):
        if modes[n + 2 * j + c + s] == OPEN and guard[n + 2 * j + c + s] <= 0.0:
            _, rate = way_left(k, p, n + 2 * j + c + s, y, y, modes)
            if rate < 0.0:
                write(events, happened, now, STRIKES, s, -rate)
                meet = True
    for place in range(n):
        i = k[k[ORDER] + place]
        if guard[i] <= 0.0 and modes[i] != STUCK and y[n + i] != 0.0:
            halt(k, place, p, y, modes)
    return meet


@part_kernel
def _through(
    k: Places,
    p: Vector,
    laws: Places,
    y: Vector,
    drive: Vector,
    modes: Places,
    work: Vector,
    pace: Vector,
    room: Room,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: Vector,
    happened: Places,
) -> int:
    """Advances by `duration` with the modes of laws that have a step of their own held."""
    n, size = k[BLOCKS], y.shape[0]
    slopes, after, end, inputs, w = room.slopes, room.lines[AFTER], room.lines[END], room.lines[INPUTS], room.w
    guard, trial, power, first_power, spent = (
        room.lines[GUARD],
        room.lines[TRIAL],
        room.lines[POWER],
        room.lines[FIRST_POWER],
        room.lines[SPENT],
    )
    before, speeds = room.places[BEFORE], room.lines[SPEEDS]
    for i in range(modes.shape[0]):
        before[i] = modes[i]
    for i in range(n):
        speeds[i] = y[n + i]
    _commanded(k, p, command, external, y, drive, inputs)
    start, t = pace[1], 0.0
    if field(k, p, laws, t, y, modes, inputs, slopes[0], w, guard, first_power) != 0:
        return LAW_FAILED
    status = OK
    if pace[0] == 0.0 or not forces_hold(k, modes, guard) or not _are_finite(slopes[0]):
        status = impacts(k, p, y, modes, room.w, work) if pace[0] == 0.0 else OK
        if status == OK:
            status = settle(k, p, laws, t, y, modes, room, work, start, events, happened)
        if pace[0] != 0.0:
            write_changes(k, start, speeds, before, modes, events, happened)
        pace[0] = max(pace[0], FIRST_STEP)
    counted, looked = 0, False
    h, within = min(pace[0], duration), _longest(k, p, inputs)
    while t < duration and status == OK:
        if _is_settled(k, y, slopes[0], inputs):
            t = duration
            break
        h = min(h, duration - t, within if t < MANY_LAGS * within else duration)
        error, seen = try_step(k, p, laws, t, h, tolerance, y, modes, room)
        if error > 1.0:
            if h <= SHORTEST * max(t, 1.0):
                status = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
                break
            h *= max(SHRINKAGE, SAFETY * error**-0.125) if math.isfinite(error) else SHRINKAGE
            looked = False
            continue
        broken = False
        for index in range(k[BLOCKS] + 2 * k[JOINTS] + k[COUPLINGS] + k[STOPS]):
            broken = broken or is_broken(k, p, index, end, modes, trial)
        if k[INNER] > 0:
            sooner = first_reversal(k, p, h, y, end)
            if sooner < h:
                h = sooner
                continue
        if not broken and not looked:
            sooner = min(seen * h, first_dip(k, p, h, y, slopes[0], end, after, modes, guard))
            if sooner < h:
                looked, h = True, sooner
                continue
        taken, longer = h, h * (GROWTH if error == 0.0 else min(GROWTH, max(SHRINKAGE, SAFETY * error**-0.125)))
        if broken:
            taken, failed = locate(k, p, laws, t, h, tolerance, y, modes, room)
            if failed:
                status = NOT_FINITE
                break
        last = taken == duration - t
        t = duration if last and not broken else t + taken
        for i in range(size):
            y[i] = end[i]
            slopes[0, i] = after[i]
        for e in range(work.shape[0]):
            work[e] += spent[e]
            first_power[e] = power[e]
        for i in range(guard.shape[0]):
            guard[i] = trial[i]
        if k[INNER] > 0:
            failed_law, changed = remember(k, p, laws, y, end)
            if changed:
                failed_law += field(k, p, laws, t, y, modes, inputs, slopes[0], w, guard, first_power)
            if failed_law != 0:
                status = LAW_FAILED
                break
        if not broken:
            pace[0], h = (max(pace[0], longer) if looked or last else longer), longer
            looked = False
            continue
        looked = False
        counted += 1
        if counted > MAX_EVENTS:
            status = TOO_MANY_EVENTS
            break
        for i in range(modes.shape[0]):
            before[i] = modes[i]
        for i in range(n):
            speeds[i] = y[n + i]
        if _happen(k, p, start + t, y, modes, guard, events, happened):
            status = impacts(k, p, y, modes, room.w, work)
        align(k, p, y, modes)
        if status == OK:
            status = settle(k, p, laws, t, y, modes, room, work, start + t, events, happened)
        write_changes(k, start + t, speeds, before, modes, events, happened)
        h = pace[0]
    _flows(k, p, inputs, t, drive)
    pace[1], pace[2] = start + t, t
    return status


@kernel
def held_command(
    k: Places,
    p: Vector,
    laws: Places,
    y: Vector,
    drive: Vector,
    modes: Places,
    work: Vector,
    pace: Vector,
    w: Vector,
    slopes: Vector,
    lines: Vector,
    places: Places,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: Vector,
    happened: Places,
) -> int:
    """`advance`, with the parts of its room one by one."""
    room = Room(w, slopes, lines, places)
    n, total = k[BLOCKS], duration
    for i in range(y.shape[0]):
        total += y[i]
    for s in range(k[SOURCES]):
        total += command[s]
    for i in range(n):
        total += external[i]
    if not math.isfinite(total) or duration < 0.0:
        return NOT_FINITE
    if k[TIMED] == 0:
        return _through(k, p, laws, y, drive, modes, work, pace, room, command, external, duration, tolerance, events, happened)
    parts = max(1, math.ceil(duration / pace[3] - 1e-6))
    for _ in range(parts):
        _commanded(k, p, command, external, y, drive, room.lines[INPUTS])
        status = field(k, p, laws, 0.0, y, modes, room.lines[INPUTS], room.slopes[0], room.w, room.lines[GUARD], room.lines[FIRST_POWER])
        if status + switch(k, p, laws, y, modes, room.w) != 0:
            return LAW_FAILED
        status = _through(k, p, laws, y, drive, modes, work, pace, room, command, external, duration / parts, tolerance, events, happened)
        if status != OK:
            return status
        if keep(k, p, laws, y, modes) != 0:
            return LAW_FAILED
    return OK


_a: Any = types.float64[::1]
_m: Any = types.float64[:, ::1]
_i: Any = types.int64[::1]
_j: Any = types.int64[:, ::1]
_f: Any = types.float64
ADVANCE: Any = types.FunctionType(types.int64(_i, _a, _j, _a, _a, _i, _a, _a, _m, _m, _m, _j, _a, _a, _f, _f, _m, _i))


@by_address
def _by_address(
    _: Any,
    address: Any,
    k: Any,
    p: Any,
    laws: Any,
    y: Any,
    drive: Any,
    modes: Any,
    work: Any,
    pace: Any,
    w: Any,
    slopes: Any,
    lines: Any,
    places: Any,
    command: Any,
    external: Any,
    duration: Any,
    tolerance: Any,
    events: Any,
    happened: Any,
) -> Any:
    return called(ADVANCE)


@inset_kernel
def advance(
    k: Places,
    p: Vector,
    laws: Places,
    y: Vector,
    drive: Vector,
    modes: Places,
    work: Vector,
    pace: Vector,
    room: Room,
    command: Vector,
    external: Vector,
    duration: float,
    tolerance: float,
    events: Vector,
    happened: Places,
) -> int:
    """Advances the state, in place, by `duration` [s] under held commands (u,) and efforts on blocks (n,) [N | N m].

    k, p, laws: a Machine. y, drive, modes, work, pace: a State. events (m, 4): rows of engine/mechanism/events.py, counted by happened[0];
    those without room are counted only. pace[1] is the time of all calls. The winding's bound is that of the speed at the beginning.
    Called by its address, which laws has in its last row: what calls this is compiled without it.
    Returns engine/status.py; where that is not OK, the state is that of the last event or step.
    """
    status: int = _by_address(
        laws[laws.shape[0] - 1, 0],
        k,
        p,
        laws,
        y,
        drive,
        modes,
        work,
        pace,
        room.w,
        room.slopes,
        room.lines,
        room.places,
        command,
        external,
        duration,
        tolerance,
        events,
        happened,
    )
    return status
