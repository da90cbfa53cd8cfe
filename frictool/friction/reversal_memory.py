"""The memory of a hysteresis: the reversals that still affect the force.

    memory = [z, F, count, forgotten, z_1, F_1, z_2, F_2, ...]

z and F are the present position and force. `count` reversals (z_k, F_k) follow, oldest first. A
hysteresis with odd symmetry starts at z = 0, F = 0 and follows these rules:

    no reversal            the virgin curve, outwards (rule I)
    last reversal (z_k)    the branch that starts there (rule II)
    an inner loop closes   when z passes z_{k-1} again: z_k and z_{k-1} are forgotten, and the
                           older branch continues
    the outer loop closes  when z passes -z_1: the virgin curve continues

Source: annex A of the thesis, figure 1. The result depends on the sequence of positions only: the
operator is rate independent, and a larger movement wipes out the memory of smaller movements. The
annex calls the memory a FIFO; in fact the memory is a stack.

A slow ringing may nest more reversals than the memory can store. Then two neighbouring reversals
are removed: the pair that differs least in position from the reversals before and after it.
`forgotten` counts the removed pairs. The present force does not change. A later force is inexact
only if a loop closes on the branch of a removed pair.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.friction.status_codes import MEMORY_FULL, NOT_FINITE, OK
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

POSITION, FORCE, COUNT, FORGOTTEN, FIRST = 0, 1, 2, 3, 4
FEWEST = 4  # least number of reversals that contain an inner pair to remove
DEPTH = 64  # largest number of nested reversals in the memory of a law


@kernel
def new_memory(depth: int) -> Vector:
    """Return the memory (4 + 2 depth,) of a virgin contact for `depth` nested reversals."""
    return np.zeros(FIRST + 2 * depth)


@kernel
def surviving(memory: Vector, z: float) -> tuple[int, bool]:
    """Return the number of reversals that remain after a monotonic movement to z, and a flag.

    The flag is True if the present position becomes a new reversal. The memory is not changed.
    """
    here = memory[POSITION]
    count = int(memory[COUNT])
    moved = z - here
    if moved == 0.0:
        return count, False
    left = memory[FIRST + 2 * (count - 1)] if count > 0 else 0.0
    if moved * (here - left) < 0.0:
        reached = abs(z) >= abs(here) if count == 0 else (z - left) * moved >= 0.0
        if not reached:
            return count, True
        count = max(0, count - 1)
    while count > 0:
        closing = memory[FIRST + 2 * (count - 2)] if count > 1 else -memory[FIRST]
        if (z - closing) * moved < 0.0:
            break
        count = max(0, count - 2)
    return count, False


@kernel
def branch_start(memory: Vector, z: float) -> tuple[bool, float, float]:
    """Return (virgin, position, force) at the start of the branch that a movement to z follows.

    `virgin` is True on the virgin curve, which starts at (0, 0).
    """
    count, turned = surviving(memory, z)
    if turned:
        return False, memory[POSITION], memory[FORCE]
    if count == 0:
        return True, 0.0, 0.0
    last = FIRST + 2 * (count - 1)
    return False, memory[last], memory[last + 1]


@kernel
def _forget_a_pair(memory: Vector, count: int) -> None:
    """Remove two successive reversals, those that differ least in position from their neighbours.

    The oldest and the newest reversal remain.
    """
    chosen = 1
    least = math.inf
    for j in range(1, count - 2):
        at = FIRST + 2 * j
        change = abs(memory[at + 2] - memory[at - 2]) + abs(memory[at + 4] - memory[at])
        if change < least:
            chosen, least = j, change
    for index in range(FIRST + 2 * chosen, FIRST + 2 * (count - 2)):
        memory[index] = memory[index + 4]
    memory[FORGOTTEN] += 1.0


@kernel
def remember(memory: Vector, z: float, force: float) -> int:
    """Store a monotonic movement to z and the force there; return a status code."""
    if not (math.isfinite(z) and math.isfinite(force)):
        return NOT_FINITE
    count, turned = surviving(memory, z)
    if turned:
        if FIRST + 2 * count + 1 >= memory.shape[0]:
            if count < FEWEST:
                return MEMORY_FULL
            _forget_a_pair(memory, count)
            count -= 2
        index = FIRST + 2 * count
        memory[index], memory[index + 1] = memory[POSITION], memory[FORCE]
        count += 1
    memory[COUNT] = count
    memory[POSITION], memory[FORCE] = z, force
    return OK
