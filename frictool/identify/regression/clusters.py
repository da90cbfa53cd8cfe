"""What counts as independent when intervals are made: strokes, as a rule.

Strokes that repeat each other to the count repeat the encoder's error too: they are one cluster
together, however many they are. A servo on a sine of constant amplitude gives such strokes, and
counting each of them would halve the interval. Where strokes are few, each is cut into equal parts
instead, so that a spread can be told at all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.identify.motion_record import Vector

Numbers = NDArray[np.int64]
FEWEST_CLUSTERS = (
    12  # fewer tell no spread: strokes are cut into parts, and repetitions are not merged
)
SAME_COUNTS = (
    3.0  # strokes repeat each other where they pass the same number of counts to within this,
)
SAME_ROWS = 2  # in the same number of rows to within this


def clusters(stroke: Numbers, sign: Vector, counts: Vector, shortest: int) -> Numbers:
    """Numbers (n,) from 0 of the clusters of rows, each (n,): `stroke` ascending, `counts` the
    encoder counts that pass in the row.

    shortest: rows over which residuals are correlated, so that a part of a stroke is longer.
    """
    starts = np.flatnonzero(np.concatenate(([True], np.diff(stroke) != 0)))
    lengths = np.diff(np.append(starts, stroke.size))
    if starts.size >= FEWEST_CLUSTERS:
        group = _repetitions(sign[starts], np.add.reduceat(counts, starts), lengths)
        chosen = group if group.max() + 1 >= FEWEST_CLUSTERS else np.arange(starts.size)
        return np.asarray(np.repeat(chosen, lengths), dtype=np.int64)
    parts = np.maximum(
        np.minimum(-(-FEWEST_CLUSTERS // starts.size), lengths // max(shortest, 1)), 1
    )
    within = np.arange(stroke.size) - np.repeat(starts, lengths)
    part = within * np.repeat(parts, lengths) // np.repeat(lengths, lengths)
    return np.asarray(np.repeat(np.cumsum(parts) - parts, lengths) + part, dtype=np.int64)


def _repetitions(sign: Vector, counts: Vector, rows: Numbers) -> Numbers:
    """Numbers (m,) from 0 of the groups of m strokes that repeat each other; a stroke that nothing
    repeats is a group of its own."""
    order = np.lexsort((counts, rows, sign))
    group, found = np.full(sign.size, -1, dtype=np.int64), 0
    for place, stroke in enumerate(order):
        for other in order[place - 1 :: -1] if place else ():
            if sign[other] != sign[stroke] or rows[stroke] - rows[other] > SAME_ROWS:
                break
            if abs(counts[stroke] - counts[other]) <= SAME_COUNTS:
                group[stroke] = group[other]
                break
        if group[stroke] < 0:
            group[stroke], found = found, found + 1
    return group
