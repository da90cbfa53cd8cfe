"""Preisach hysteresis of 20 x 20 cells along a path of nested loops.

frictool's Everett stack is compared with the bank of relays of (3.18); both are compiled. The bank
has one relay in the middle of each cell, so that its force changes in steps. Errors are relative to
the Masing hysteresis from whose centred cycles the weights of the cells were computed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.friction.masing import masing_move
from frictool.friction.preisach import preisach_force, preisach_move
from frictool.friction.preisach_cycles import cell_weights, masing_everett
from frictool.friction.reversal_memory import FORCE, new_memory
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

POINTS, ROUNDS = 50_000, 7


@kernel
def stack_path(path: Vector, table: Vector, memory: Vector, forces: Vector) -> None:
    """Fill `forces` (n,) along the path (n,) by the Everett stack, in units of F_s and z_max."""
    for k in range(path.shape[0]):
        forces[k] = preisach_force(memory, path[k], table, 1.0, 1.0)
        preisach_move(memory, path[k], table, 1.0)


@kernel
def relay_path(
    path: Vector, up: Vector, down: Vector, share: Vector, state: Vector, forces: Vector
) -> None:
    """Fill `forces` (n,) along the path (n,) by m relays, in units of F_s and z_max.

    up, down, share, state: switching positions `up` >= `down`, weight and state of each relay (m,)
    """
    for k in range(path.shape[0]):
        total = 0.0
        for i in range(up.shape[0]):
            if up[i] < path[k]:
                state[i] = 1.0
            elif down[i] > path[k]:
                state[i] = -1.0
            total += share[i] * state[i]
        forces[k] = total


def relays(table: Vector) -> tuple[Vector, Vector, Vector, Vector]:
    """Return switching positions `up` and `down`, weight and demagnetised state of each relay."""
    weights = cell_weights(table)
    cells = weights.shape[0]
    places = (np.arange(cells) + 0.5) * 2.0 / cells - 1.0
    up, down = np.meshgrid(places, places, indexing="ij")
    kept = np.tril_indices(cells)
    tilt = (up + down)[kept]
    return up[kept], down[kept], weights[kept], np.where(np.abs(tilt) < 1e-9, 0.0, -np.sign(tilt))


def by_relays(path: Vector, table: Vector) -> Vector:
    forces = np.empty_like(path)
    relay_path(path, *relays(table), forces)
    return forces


def by_stack(path: Vector, table: Vector) -> Vector:
    forces = np.empty_like(path)
    stack_path(path, table, new_memory(64), forces)
    return forces


def friction_preisach() -> dict[str, Any]:
    """Return the row of the wall time of one step of the operator."""
    t = np.linspace(0.0, 400.0, POINTS)
    path = 0.6 * np.sin(t) + 0.35 * np.sin(3.7 * t)
    table = masing_everett()
    ours, theirs = (
        seconds / POINTS
        for seconds in pair(lambda: by_stack(path, table), lambda: by_relays(path, table), ROUNDS)
    )
    exact, memory = np.empty_like(path), new_memory(64)
    for k, place in enumerate(path):
        masing_move(memory, place, 1.0, 1.0)
        exact[k] = memory[FORCE]
    errors = [
        float(np.max(np.abs(found - exact)))
        for found in (by_stack(path, table), by_relays(path, table))
    ]
    return {
        "id": "friction.preisach",
        "peer": "bank of 210 relays (numba)",
        "ours": ours,
        "theirs": theirs,
        "unit": "s/step",
        "ratio": theirs / ours,
        "accuracy": f"force within {errors[0]:.1e} F_s, peer {errors[1]:.1e} F_s",
    }


ROWS = [friction_preisach]
