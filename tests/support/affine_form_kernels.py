"""Compiled operations on affine forms. The module imports little, because its imports are part of
the key of its stored kernels."""

from __future__ import annotations

import numpy as np

from frictool.prove import affine_forms as af
from frictool.prove import axis_forms as forms
from frictool.runtime.kernels import kernel


@kernel
def operate(f: af.Forms, random: np.ndarray, values: np.ndarray, noise: np.ndarray) -> float:
    """Compute random operations on forms and on one value of each; return the worst distance."""
    worst = 0.0
    rows = values.size
    for k in range(random.shape[0]):
        d, a, b = int(random[k, 0]), int(random[k, 1]), int(random[k, 2])
        operation = int(random[k, 3])
        if operation == 0:
            af.combine(f, d, random[k, 4], a, random[k, 5], b, random[k, 6], 0.0)
            values[d] = random[k, 4] * values[a] + random[k, 5] * values[b] + random[k, 6]
        elif operation == 1:
            af.multiply(f, d, a, b)
            values[d] = values[a] * values[b]
        elif operation == 2:
            af.add_generator(f, d, 0.1)
            values[d] += 0.1 * noise[k]
        else:
            af.release(f, d, 1e-6)
        if abs(values[d]) > 3.0:
            af.combine(f, d, 0.2, d, 0.0, d, 0.0, 0.0)
            values[d] *= 0.2
        for row in range(rows):
            worst = max(worst, af.lowest(f, row) - values[row], values[row] - af.highest(f, row))
    return worst


@kernel
def reduced(f: af.Forms, rows: np.ndarray, score: np.ndarray) -> None:
    af.reduce_forms(f, rows, 3, 10, score)


@kernel
def advanced(f: af.Forms, cell: forms.AxisCell, m: np.ndarray) -> None:
    forms.advance(f, 0, cell, m)
