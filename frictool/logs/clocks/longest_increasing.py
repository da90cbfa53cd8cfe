"""Longest strictly increasing subsequence of sample times, used if a clock has jumped back.

The algorithm is Fredman's (1975).
"""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from frictool.logs.raw_table import Nanoseconds


def increasing(time: Nanoseconds, after: int | None) -> NDArray[np.intp]:
    """Return the indices (m,) of a longest strictly increasing subsequence of times (n,) in ns.

    after: time in ns that must precede all times of the subsequence; None for no limit.
    """
    ends: list[int] = []  # smallest last time of a subsequence of each length
    indices: list[int] = []
    before = np.full(time.size, -1)
    for index, value in enumerate(time.tolist()):
        if after is not None and value <= after:
            continue
        length = bisect_left(ends, value)
        before[index] = indices[length - 1] if length else -1
        ends[length : length + 1] = [value]
        indices[length : length + 1] = [index]
    chosen = np.empty(len(indices), dtype=np.intp)
    index = indices[-1] if indices else -1
    for position in range(len(indices) - 1, -1, -1):
        chosen[position] = index
        index = int(before[index])
    return chosen
