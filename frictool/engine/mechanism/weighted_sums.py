"""Weighted sums of a step's slopes (derivatives): stage points, end, error and dense output.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5, II.6, II.10.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.engine.mechanism.dormand_prince8 import (
    AFTER,
    ERRORS_3,
    ERRORS_5,
    MORE_ROWS,
    PATH,
    ROWS,
    WEIGHTS,
)
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector

FOUR = 4
BUMPS = 7  # number of rows with coefficients of a dense output


def _terms(rows: Sequence[Sequence[float]]) -> tuple[IntVector, Vector, IntVector]:
    kept = [[(index, weight) for index, weight in enumerate(row) if weight != 0.0] for row in rows]
    width = max(len(row) + -len(row) % FOUR for row in kept)
    indices, weights = np.zeros((len(rows), width), dtype=np.int64), np.zeros((len(rows), width))
    for at, row in enumerate(kept):
        indices[at, : len(row)] = [index for index, _ in row]
        weights[at, : len(row)] = [weight for _, weight in row]
    return indices, weights, np.array([len(row) for row in kept])


STAGE_INDICES, STAGE_WEIGHTS, STAGE_TERMS = _terms([(), *ROWS, WEIGHTS.tolist(), *MORE_ROWS])
PATH_INDICES, PATH_WEIGHTS, PATH_TERMS = _terms(PATH.tolist())
ERROR_INDICES, ERROR_WEIGHTS, ERROR_TERMS = _terms(
    [np.where(ERRORS_3 != 0.0, e, 0.0).tolist() for e in (ERRORS_5, ERRORS_3)]
)


@bare_kernel
def _add(
    h: float, indices: IntVector, weights: Vector, terms: int, slopes: Vector, point: Vector
) -> None:
    for first in range(0, terms, FOUR):
        j0 = indices[first]
        j1 = indices[first + 1]
        j2 = indices[first + 2]
        j3 = indices[first + 3]
        w0 = h * weights[first]
        w1 = h * weights[first + 1]
        w2 = h * weights[first + 2]
        w3 = h * weights[first + 3]
        for i in range(slopes.shape[1]):
            point[i] += (
                w0 * slopes[j0, i] + w1 * slopes[j1, i] + w2 * slopes[j2, i] + w3 * slopes[j3, i]
            )


@bare_kernel
def stage_point(stage: int, h: float, y: Vector, slopes: Vector, point: Vector) -> None:
    """Fill `point` with the state at a stage; for stage AFTER, with the state at the step's end.

    y (n,), point (n,) or longer, slopes (stages, n).
    """
    for i in range(y.shape[0]):
        point[i] = y[i]
    _add(h, STAGE_INDICES[stage], STAGE_WEIGHTS[stage], STAGE_TERMS[stage], slopes, point)


@bare_kernel
def gained(h: float, slopes: Vector, gain: Vector) -> None:
    """Write the change of the state over a step of length h to `gain` (n,)."""
    for i in range(slopes.shape[1]):
        gain[i] = 0.0
    _add(h, STAGE_INDICES[AFTER], STAGE_WEIGHTS[AFTER], STAGE_TERMS[AFTER], slopes, gain)


@bare_kernel
def step_errors(h: float, slopes: Vector, fifth: Vector, third: Vector) -> None:
    """Fill `fifth` with the error of each state, h e5^2 / sqrt(e5^2 + e3^2/100).

    h is the step's length; e5 and e3 are the error estimates of order 5 and 3 (Hairer, equation
    II.10.17). fifth (n,) or longer; third: workspace of the same length.
    """
    size = slopes.shape[1]
    for i in range(size):
        fifth[i], third[i] = 0.0, 0.0
    _add(1.0, ERROR_INDICES[0], ERROR_WEIGHTS[0], ERROR_TERMS[0], slopes, fifth)
    _add(1.0, ERROR_INDICES[1], ERROR_WEIGHTS[1], ERROR_TERMS[1], slopes, third)
    for i in range(size):
        square = fifth[i] * fifth[i]
        total = square + 0.01 * third[i] * third[i]
        fifth[i] = abs(h) * square / np.sqrt(total) if total > 0.0 else 0.0


@bare_kernel
def path_of(h: float, slopes: Vector, path: Vector) -> None:
    """Write the coefficients of a step's dense output (Hairer, II.6) to `path` (BUMPS, n).

    slopes: one row per stage, including the three stages that only the dense output needs.
    """
    gained(h, slopes, path[0])
    for i in range(slopes.shape[1]):
        path[1, i] = h * slopes[0, i] - path[0, i]
        path[2, i] = 2.0 * path[0, i] - h * (slopes[0, i] + slopes[AFTER, i])
    for row in range(BUMPS - 3):
        bump = path[3 + row]
        for i in range(slopes.shape[1]):
            bump[i] = 0.0
        _add(h, PATH_INDICES[row], PATH_WEIGHTS[row], PATH_TERMS[row], slopes, bump)


@bare_kernel
def on_path(part: float, path: Vector, gain: Vector) -> None:
    """Write the change of the state over the first part of a step to `gain` (n,).

    - part: length of this first part, divided by the length of the step
    - path: coefficients of the step's dense output (`path_of`)
    """
    rest = 1.0 - part
    for i in range(path.shape[1]):
        inner = path[4, i] + rest * (path[5, i] + part * path[6, i])
        gain[i] = part * (
            path[0, i]
            + rest * (path[1, i] + part * (path[2, i] + rest * (path[3, i] + part * inner)))
        )
