"""Velocity errors of low-pass filters of the difference quotient of the encoder's position.

The bank has m bandwidths (control/speed_filter.py), and 2 m + 1 errors:

entry 0             difference quotient u, not filtered
entries 1 .. m      first-order low-pass of each bandwidth, v = a v' + b (u + u')
entries m+1 .. 2m   the same low-pass applied twice (thesis 5.70)

v is the output of a filter; a prime marks the value at the previous sample.
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel
from frictool.typing import Matrix, Vector


@kernel
def low_pass_bank(
    difference: Vector,
    reference: Vector,
    pole: Vector,
    gain: Vector,
    state: Matrix,
    squares: Vector,
) -> None:
    """Add the squared velocity errors of each filter, summed over n samples, to `squares`.

    Parameters
    ----------
    difference
        Difference quotient (n,) of the encoder's position [rad/s | m/s], the filters' input.
    reference
        Velocity (n,) from which the errors are computed [rad/s | m/s].
    pole, gain
        Coefficients a (m,) and b (m,) of the low-passes.
    state
        (3, m): input, output of the first stage and output of the second stage at the previous
        sample; updated in place.
    squares
        (2 m + 1,): sums of (output - reference)^2 in the order of the module's table; updated in
        place.
    """
    bank = pole.shape[0]
    before, once, twice = state[0], state[1], state[2]
    first = squares[1 : 1 + bank]
    second = squares[1 + bank :]
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
