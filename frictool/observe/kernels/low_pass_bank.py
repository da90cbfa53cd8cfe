"""Bank of low-passes on the encoder's difference (control/speed_filter.py), and their errors.

column 0            the difference itself
columns 1 .. b      first order at each bandwidth      v = a v' + b (u + u')
columns b+1 .. 2b   the same twice: (5.70)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@kernel
def low_pass_bank(
    difference: Vector,
    reference: Vector,
    pole: Vector,
    gain: Vector,
    state: Matrix,
    squares: Vector,
) -> None:
    """Add the squared errors (filtered - reference)^2 of the samples (n,) to squares (2 b + 1,).

    pole, gain: a and b (b,). state: (3, b), updated in place: difference, first and second stage at
    the sample before.
    """
    bank = pole.shape[0]
    before, once, twice = state[0], state[1], state[2]
    first, second = squares[1 : 1 + bank], squares[1 + bank :]
    last = before[0] if bank > 0 else 0.0
    for k in range(difference.shape[0]):
        u, wanted = difference[k], reference[k]
        squares[0] += (u - wanted) * (u - wanted)
        both = u + last
        last = u
        for j in range(bank):
            new = pole[j] * once[j] + gain[j] * both
            newer = pole[j] * twice[j] + gain[j] * (new + once[j])
            once[j] = new
            twice[j] = newer
            first[j] += (new - wanted) * (new - wanted)
            second[j] += (newer - wanted) * (newer - wanted)
    before[:] = last
