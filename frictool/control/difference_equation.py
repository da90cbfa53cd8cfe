"""The linear speed controller as a difference equation in state-space form, with the observer form of anti-windup.

    u[k] = c x[k] + d eta[k],   x[k+1] = a x[k] + b eta[k] + l (limited u[k] - u[k])

A system of order n is flat: a (n x n, row-major), b (n), c (n), d, l (n). Sums are formed in the order written, which the C form repeats.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import kernel

Vector = NDArray[np.float64]


@kernel
def equation_output(parameters: Vector, system: int, state: Vector, x: int, n: int, eta: float) -> float:
    """The drive [A | V] before its limit, d eta + c x.

    The system lies in `parameters` from place `system` on, the state in `state` from place `x` on: n numbers, and n more of scratch.
    """
    c = system + n * n + n
    drive: float = parameters[c + n] * eta
    for i in range(n):
        drive += parameters[c + i] * state[x + i]
    return drive


@kernel
def equation_advance(parameters: Vector, system: int, state: Vector, x: int, n: int, eta: float, excess: float) -> None:
    """Moves x to the next sample in place; excess = limited drive - drive [A | V]; places as in `equation_output`."""
    b = system + n * n
    gain = b + 2 * n + 1
    for i in range(n):
        value = parameters[b + i] * eta + parameters[gain + i] * excess
        for j in range(n):
            value += parameters[system + i * n + j] * state[x + j]
        state[x + n + i] = value
    for i in range(n):
        state[x + i] = state[x + n + i]
