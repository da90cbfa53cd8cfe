"""QR by blocks of rows (TSQR of Demmel, Grigori, Hoemmen and Langou 2012).

Each group of successive rows is reduced to a triangular matrix R with R^T R = rows^T rows. R
contains all information for least squares with full precision. Stacked matrices R are reduced again
by QR, as if they were rows. To leave out a group of rows, the R of this group is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector

Tensor = NDArray[np.float64]
BLOCK = 64  # rows reduced at a time
# Below this bound a sum of squares is subnormal or nearly subnormal and has lost digits. A
# Householder reflection divides by the sum of squares of its column; a column whose sum is below
# the bound is therefore not reflected.
UNDERFLOW = 1e-290
# largest number of rows that are copied into one array for the kernel
PIECE = 512 * BLOCK


@kernel
def reduce_rows(
    columns: NDArray[np.float64], weight: Vector, starts: IntVector, out: Tensor
) -> None:
    """Reduce q weighted columns (q, n) to the triangular matrices `out` (g, q, q) of g groups.

    Group i consists of the rows starts[i] to starts[i+1] - 1; `starts` is (g + 1,). Each block of
    rows is reduced together with the triangular matrix of the previous blocks, by Householder
    reflections.
    """
    q = columns.shape[0]
    block = np.empty((q, BLOCK))
    for run in range(starts.shape[0] - 1):
        triangle = out[run]
        for first in range(starts[run], starts[run + 1], BLOCK):
            rows = min(BLOCK, starts[run + 1] - first)
            for j in range(q):
                column = columns[j]
                for k in range(rows):
                    block[j, k] = weight[first + k] * column[first + k]
            for j in range(q):
                below = 0.0
                for k in range(rows):
                    below += block[j, k] * block[j, k]
                if below < UNDERFLOW:
                    continue
                norm = math.sqrt(triangle[j, j] * triangle[j, j] + below)
                head = triangle[j, j] + math.copysign(norm, triangle[j, j])
                scale = 2.0 / (head * head + below)
                triangle[j, j] = -math.copysign(norm, triangle[j, j])
                for i in range(j + 1, q):
                    along = head * triangle[j, i]
                    for k in range(rows):
                        along += block[j, k] * block[i, k]
                    along *= scale
                    triangle[j, i] -= along * head
                    for k in range(rows):
                        block[i, k] -= along * block[j, k]


def triangles(columns: tuple[Vector, ...], weight: Vector, starts: IntVector) -> Tensor:
    """Return the triangular matrices (g, q, q) of g groups of rows, from q columns (n,).

    - weight: weight of each row, (n,)
    - starts: index of the first row of each group, (g,)
    """
    out = np.zeros((starts.size, len(columns), len(columns)))
    for run, bounds in _pieces(np.append(starts, weight.size).astype(np.int64)):
        rows = slice(bounds[0], bounds[-1])
        side_by_side = np.array([column[rows] for column in columns], dtype=np.float64)
        reduce_rows(side_by_side, np.ascontiguousarray(weight[rows]), bounds - bounds[0], out[run:])
    return out


def _pieces(starts: IntVector) -> Iterator[tuple[int, IntVector]]:
    run = 0
    row = int(starts[0])
    while run < starts.size - 1:
        # cut at a whole number of blocks, so that the blocks do not change
        if starts[run + 1] - row > PIECE:
            yield run, np.array([row, row + PIECE])
            row += PIECE
        else:
            last = int(np.searchsorted(starts, row + PIECE, side="right")) - 1
            yield run, np.concatenate([[row], starts[run + 1 : last + 1]])
            run = last
            row = int(starts[last])


def merged(parts: Tensor) -> NDArray[np.float64]:
    """Return the triangular matrix (q, q) of all rows, from the matrices of g groups (g, q, q)."""
    return np.asarray(np.linalg.qr(parts.reshape(-1, parts.shape[2]), mode="r"))
