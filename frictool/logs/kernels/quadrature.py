r"""Counting of an encoder's quadrature channels A and B, four counts per period.

A leads B if the count rises.

    A   __/~~\__/~~          state  A B    00  10  11  01
    B   ____/~~\__           count mod 4    0   1   2   3

From one sample to the next, the state may stay or advance by one place in this sequence, in either
direction. A change by two places is an illegal transition, because its direction is unknown.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel

UNKNOWN = -1  # level before the first sample
LEVEL_A, LEVEL_B, COUNT, ILLEGAL = 0, 1, 2, 3  # indices into the state
TURN = np.array([0, 3, 1, 2])  # count modulo 4 for the state 2 A + B


@kernel
def count_quadrature(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    low: float,
    high: float,
    state: NDArray[np.int64],
    counts: NDArray[np.float64],
) -> None:
    """Fill `counts` (n,) with the counts at the samples a, b (n,) of the channels A and B.

    low, high: thresholds with low <= high. A channel becomes high at a sample >= `high`, and low at
        a sample <= `low`. At the start, its level is UNKNOWN; then it becomes low at any sample <
        `high`. NaN does not change the level.
    state: levels of A and B, count, and number of illegal transitions (4,), updated in place;
        (UNKNOWN, UNKNOWN, 0, 0) before the first block.
    """
    for k in range(a.size):
        before = (
            -1
            if state[LEVEL_A] == UNKNOWN or state[LEVEL_B] == UNKNOWN
            else TURN[2 * state[LEVEL_A] + state[LEVEL_B]]
        )
        for channel, value in ((LEVEL_A, a[k]), (LEVEL_B, b[k])):
            if value >= high:
                state[channel] = 1
            elif value <= low or (state[channel] == UNKNOWN and value < high):
                state[channel] = 0
        if before >= 0:
            step = (TURN[2 * state[LEVEL_A] + state[LEVEL_B]] - before) % 4
            if step == 2:
                state[ILLEGAL] += 1
            else:
                state[COUNT] += step if step < 2 else -1
        counts[k] = state[COUNT]
