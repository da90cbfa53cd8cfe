"""The most samples of a sequence whose times increase: what is kept where a clock has jumped back.

The longest increasing subsequence (Fredman 1975): the last elements of the best subsequences of
each length are kept in order, and each element replaces the first of them that is not smaller.
"""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from frictool.logs.table import Nanoseconds


def increasing(time: Nanoseconds, after: int | None) -> NDArray[np.intp]:
    """Indices (m,), ascending, of a longest strictly increasing choice of the times (n,) in ns, all
    of them later than `after`."""
    ends: list[int] = []  # the smallest last time of a choice of each length
    places: list[int] = []
    before = np.full(time.size, -1)
    for place, value in enumerate(time.tolist()):
        if after is not None and value <= after:
            continue
        length = bisect_left(ends, value)
        before[place] = places[length - 1] if length else -1
        ends[length : length + 1] = [value]
        places[length : length + 1] = [place]
    chosen = np.empty(len(places), dtype=np.intp)
    place = places[-1] if places else -1
    for position in range(len(places) - 1, -1, -1):
        chosen[position] = place
        place = int(before[place])
    return chosen
