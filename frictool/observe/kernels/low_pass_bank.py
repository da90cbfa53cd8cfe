"""The encoder's difference through many low-passes at once (control/velocity.py), and how far each is from a reference.

column 0            the difference itself
columns 1 .. b      first order at each bandwidth         v = a v' + b (u + u')
columns b+1 .. 2b   the same twice: (5.70)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import kernel

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@kernel
def low_pass_bank(difference: Vector, reference: Vector, counted: int, pole: Vector, gain: Vector, state: Matrix, squares: Vector) -> None:
    """Adds (filtered - reference)^2 of the first `counted` samples to squares (2 b + 1,); all samples (n,) move the state.

    pole, gain: a, b (b,). state (3, b): difference, first and second stage at the sample before, in place.
    """
    bank = pole.shape[0]
    for k in range(difference.shape[0]):
        u, wanted, is_counted = difference[k], reference[k], k < counted
        if is_counted:
            squares[0] += (u - wanted) * (u - wanted)
        for j in range(bank):
            once = pole[j] * state[1, j] + gain[j] * (u + state[0, j])
            twice = pole[j] * state[2, j] + gain[j] * (once + state[1, j])
            state[0, j], state[1, j], state[2, j] = u, once, twice
            if is_counted:
                squares[1 + j] += (once - wanted) * (once - wanted)
                squares[1 + bank + j] += (twice - wanted) * (twice - wanted)
