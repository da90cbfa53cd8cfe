"""Memory of dynamic laws, for example of past reversals, updated after accepted steps only."""

from __future__ import annotations

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.law_kernels import DYNAMIC, commit
from frictool.friction.status_codes import OK
from frictool.runtime.kernels import part_kernel
from frictool.typing import IntVector, Vector

AT_REVERSAL = 1e-3  # speed below which a step may pass 0, relative to the speed scale


@part_kernel
def first_reversal(k: IntVector, p: Vector, h: float, y: Vector, end: Vector) -> float:
    """Return the time within a step at which a block with a dynamic law first reverses.

    The result is the step length h [s] if no such block reverses.
    """
    n = k[ly.BLOCKS]
    shortest = h
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        if ly.kind(k, row) == DYNAMIC:
            block = ly.block(k, row)
            v0, v1 = y[n + block], end[n + block]
            if v0 * v1 < 0.0 and min(abs(v0), abs(v1)) > AT_REVERSAL * ly.speed_scale(k, p, block):
                shortest = min(shortest, h * v0 / (v0 - v1))
    return shortest


@part_kernel
def remember(machine: CompiledMechanism, y: Vector, before: Vector) -> tuple[int, bool]:
    """Update the memories of the dynamic laws after a step that ends at the state y.

    Returns a status of friction/status_codes.py, and True if an internal state has changed from
    `before`.
    """
    k, p, laws = machine
    n = k[ly.BLOCKS]
    status = OK
    changed = False
    for f in range(k[ly.FRICTIONS]):
        row = ly.friction_row(k, f)
        if ly.kind(k, row) == DYNAMIC:
            first, end = 2 * n + k[row + ly.FIRST_INNER], 2 * n + k[row + ly.INNER_END]
            values = p[ly.law_values(k, row)]
            status += commit(laws[f, 2], y[first:end], y[n + ly.block(k, row)], values)
            for i in range(first, end):
                changed = changed or y[i] != before[i]
    return status, changed
