"""QR by blocks of rows (TSQR of Demmel, Grigori, Hoemmen and Langou 2012): each run of rows is
reduced to one triangle.

A triangle R with R^T R = rows^T rows holds all that least squares needs of a run, to full
precision: the triangles of several runs, stacked, are reduced again by QR as if they were rows;
leaving a run out is leaving its triangle out. An hour of samples is read once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import Vector
from frictool.runtime.kernels import kernel

Tensor = NDArray[np.float64]
Numbers = NDArray[np.int64]
BLOCK = 64  # rows that are reduced at a time
PIECE = (
    512 * BLOCK
)  # rows that are laid out side by side for the kernel, which is compiled once for any number of columns


@kernel
def reduce_rows(columns: NDArray[np.float64], weight: Vector, starts: Numbers, out: Tensor) -> None:
    """Takes q columns (q, n) times `weight` (n,) into the triangles `out` (g, q, q); run i is rows
    starts[i] to starts[i+1] - 1.

    starts (g + 1,). Householder reflections on a triangle and the block of rows beneath it.
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
                if below == 0.0:
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


def triangles(columns: tuple[Vector, ...], weight: Vector, starts: Numbers) -> Tensor:
    """(g, q, q) triangles of g runs that begin at the rows `starts` (g,), of q columns (n,) with
    each row times its `weight` (n,)."""
    out = np.zeros((starts.size, len(columns), len(columns)))
    for run, bounds in _pieces(np.append(starts, weight.size).astype(np.int64)):
        rows = slice(bounds[0], bounds[-1])
        side_by_side = np.array([column[rows] for column in columns], dtype=np.float64)
        reduce_rows(side_by_side, np.ascontiguousarray(weight[rows]), bounds - bounds[0], out[run:])
    return out


def _pieces(starts: Numbers) -> Iterator[tuple[int, Numbers]]:
    """Runs in pieces of at most PIECE rows: the first run of each, and where it and those after it
    begin and end."""
    run, row = 0, int(starts[0])
    while run < starts.size - 1:
        if (
            starts[run + 1] - row > PIECE
        ):  # cut at a whole number of blocks: the same blocks as without
            yield run, np.array([row, row + PIECE])
            row += PIECE
        else:
            last = int(np.searchsorted(starts, row + PIECE, side="right")) - 1
            yield run, np.concatenate([[row], starts[run + 1 : last + 1]])
            run, row = last, int(starts[last])


def merged(parts: Tensor) -> NDArray[np.float64]:
    """The triangle (q, q) of all runs together, from their triangles (g, q, q)."""
    return np.asarray(np.linalg.qr(parts.reshape(-1, parts.shape[2]), mode="r"))
