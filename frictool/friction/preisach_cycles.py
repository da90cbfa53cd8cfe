"""Density of a Preisach operator from measured centred cycles (thesis 3.4.3, 3.7.1, figure 3.8).

A centred cycle of amplitude a is a movement from a to -a and back. Its descending branch gives the
Everett function E(a, beta) = (F(a) - F(beta))/2 for every beta in [-a, a]. Since the hysteresis is
odd, E(alpha, -a) = E(a, -alpha) gives the other values. If each positive node of the grid is the
amplitude of a cycle, these n/2 cycles determine the triangle of n x n cells; section 3.7.1 has n =
20 and 10 cycles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.friction.parameter import Values
from frictool.friction.virgin_curve import virgin_force
from frictool.typing import Vector

CELLS = 20  # n of 3.7.1
PLACED = 1e-6  # relative tolerance of a cycle's ends


def everett_tail(cycles: Sequence[tuple[Vector, Vector]]) -> Vector:
    """Return the Everett table of friction/preisach.py, ((n+1)^2,) with n = 2 len(cycles).

    cycles: descending branch of each cycle as a pair (positions that fall from a to -a, forces), in
    any units. The amplitudes are a = k z_max/len(cycles), k = 1, 2, ... Forces are interpolated
    between positions. Raises ValueError if there is no cycle, if a branch does not extend from a to
    -a, or if the force does not fall along the largest cycle.
    """
    count = len(cycles)
    if count == 0:
        raise ValueError("found no centred cycle; allowed: at least one, from z_max to -z_max")
    branches = [_checked(*cycle) for cycle in cycles]
    limit = float(branches[-1][0][0])
    table = np.zeros((2 * count + 1, 2 * count + 1))
    for k, (positions, forces) in enumerate(branches, start=1):
        amplitude = k * limit / count
        if max(abs(positions[0] - amplitude), abs(positions[-1] + amplitude)) > PLACED * amplitude:
            raise ValueError(
                f"cycle {k} runs from {positions[0]:g} to {positions[-1]:g}; allowed: from "
                f"{amplitude:g} to {-amplitude:g}"
            )
        nodes = np.arange(-k, k + 1)
        halves = 0.5 * (forces[0] - np.interp(nodes * limit / count, positions[::-1], forces[::-1]))
        table[count + k, count + nodes] = halves
        table[count - nodes, count - k] = halves
    saturation = table[-1, 0]
    if saturation <= 0.0:
        raise ValueError(
            "in the largest cycle, the force must fall from the first to the last position; found: "
            f"{branches[-1][1][0]:g} first, {branches[-1][1][-1]:g} last"
        )
    normal: Vector = (table / saturation).ravel()
    return normal


def _checked(positions: Vector, forces: Vector) -> tuple[Vector, Vector]:
    z, f = np.asarray(positions, dtype=np.float64), np.asarray(forces, dtype=np.float64)
    if (
        z.ndim != 1
        or z.size < 2
        or z.shape != f.shape
        or not np.all(np.isfinite([z, f]))
        or np.any(np.diff(z) >= 0.0)
    ):
        raise ValueError(
            "a descending branch needs one finite force for each position, and positions that fall"
        )
    return z, f


def masing_cycles(cells: int = CELLS) -> list[tuple[Vector, Vector]]:
    """Return cells/2 centred cycles of the Masing hysteresis with z_max = 1 (thesis, figure 3.8).

    `cells` must be even.
    """
    if cells < 2 or cells % 2:
        raise ValueError(f"cells is {cells}; allowed: an even number >= 2")
    count = cells // 2
    cycles = []
    for k in range(1, count + 1):
        z = np.arange(k, -k - 1, -1) / count
        top = virgin_force(k / count, 1.0, 1.0)
        cycles.append(
            (z, np.array([top + 2.0 * virgin_force(0.5 * (point - z[0]), 1.0, 1.0) for point in z]))
        )
    return cycles


def masing_everett() -> Vector:
    """Return the Everett table of thesis 3.7.1: n = 20, 10 cycles of the Masing hysteresis."""
    return everett_tail(masing_cycles())


def masing_table(values: Values) -> Vector:
    """Return the Everett table of the Masing hysteresis; n is `values["preisach_intervals"]`."""
    return everett_tail(masing_cycles(int(values.get("preisach_intervals", CELLS))))


def cell_count(size: int) -> int:
    """Return the number n (n + 1)/2 of triangle cells for an Everett table of `size` values."""
    cells = math.isqrt(size) - 1
    return cells * (cells + 1) // 2


def cell_weights(table: Vector) -> NDArray[np.float64]:
    """Return the integral of the density mu over each cell (thesis, figure 3.9), shape (n, n).

    Rows belong to alpha, columns to beta, the two switching positions of the relays. The sum of all
    weights is 1; the diagonal includes the elastic part.
    """
    nodes = round(float(np.sqrt(table.size)))
    e = np.tril(table.reshape(nodes, nodes))
    weights = e[1:, :-1] - e[:-1, :-1] - e[1:, 1:] + e[:-1, 1:]
    return np.tril(weights)
