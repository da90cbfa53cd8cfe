"""The memory of a hysteresis with wiping-out: the reversals that are not yet forgotten (annex A,
figure 1).

    memory = [z, F, count, forgotten, z_1, F_1, z_2, F_2, ...]     where it is now; then the
                                                                   reversals' positions and forces,
                                                                   oldest first

Rules, for an odd hysteresis that starts virgin at z = 0, F = 0:
    no reversal           the virgin curve, outwards
                          rule I
    last reversal (z_k)   the branch that leaves it
                          rule II
    an inner loop closes  where z passes z_{k-1} again, z_k and z_{k-1} are forgotten and the older
    branch goes on
    the outer loop        where z passes -z_1 the virgin curve goes on
Seen from outside, nothing but the position decides: the operator is rate independent and wiped out
by larger movements. The annex calls the memory a FIFO; it is a stack. It overflows where more
reversals are nested than it holds, as in a slow ringing: then the pair of neighbours that differ
least from the pairs around them is given up, and `forgotten` counts it. The force stays as it is;
later, where a loop closes on the branch of that pair, it is off by what the neighbours differ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.friction.status import MEMORY_FULL, NOT_FINITE, OK
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]

POSITION, FORCE, COUNT, FORGOTTEN, FIRST = 0, 1, 2, 3, 4
FEWEST = 4  # reversals without which there is no inner pair to give up
DEPTH = 64  # nested reversals that a law's memory holds


@kernel
def new_memory(depth: int) -> Vector:
    """The memory of a virgin contact that holds `depth` nested reversals, shape (4 + 2 depth,)."""
    return np.zeros(FIRST + 2 * depth)


@kernel
def surviving(memory: Vector, z: float) -> tuple[int, bool]:
    """After a straight movement to z: how many of the stored reversals remain, and whether the
    present place is one more.

    Read-only: a solver may try any z before `remember` accepts one.
    """
    here, count = memory[POSITION], int(memory[COUNT])
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
    """What a straight movement to z follows: (virgin?, position, force) of the reversal that its
    branch leaves."""
    count, turned = surviving(memory, z)
    if turned:
        return False, memory[POSITION], memory[FORCE]
    if count == 0:
        return True, 0.0, 0.0
    last = FIRST + 2 * (count - 1)
    return False, memory[last], memory[last + 1]


@kernel
def _forget_a_pair(memory: Vector, count: int) -> None:
    """Gives up the two neighbours, neither oldest nor newest, without which the reversals around
    them change least."""
    chosen, least = 1, math.inf
    for j in range(1, count - 2):
        at = FIRST + 2 * j
        change = abs(memory[at + 2] - memory[at - 2]) + abs(memory[at + 4] - memory[at])
        if change < least:
            chosen, least = j, change
    for place in range(FIRST + 2 * chosen, FIRST + 2 * (count - 2)):
        memory[place] = memory[place + 4]
    memory[FORGOTTEN] += 1.0


@kernel
def remember(memory: Vector, z: float, force: float) -> int:
    """Takes a straight movement to z, where the operator's force is `force`, into the memory.
    Returns friction/status.py."""
    if not (math.isfinite(z) and math.isfinite(force)):
        return NOT_FINITE
    count, turned = surviving(memory, z)
    if turned:
        if FIRST + 2 * count + 1 >= memory.shape[0]:
            if count < FEWEST:
                return MEMORY_FULL
            _forget_a_pair(memory, count)
            count -= 2
        place = FIRST + 2 * count
        memory[place], memory[place + 1] = memory[POSITION], memory[FORCE]
        count += 1
    memory[COUNT] = count
    memory[POSITION], memory[FORCE] = z, force
    return OK
