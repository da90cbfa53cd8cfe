"""Clusters of regression rows; residuals of different clusters are taken as independent.

Usually a cluster is a stroke (the motion between two reversals). Strokes in the same direction that
agree in length within SAME_COUNTS encoder counts and SAME_ROWS rows have nearly the same encoder
errors, and form one cluster. Such strokes occur if a servo follows a sine of constant amplitude. If
there are few strokes, each stroke is cut into equal parts, which are the clusters.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import IntVector, Vector

# least number of clusters; with fewer clusters, strokes are cut into parts, and repetitions are not
# merged
FEWEST_CLUSTERS = 12
SAME_COUNTS = 3.0  # largest difference of counts between strokes that repeat each other
SAME_ROWS = 2  # largest difference of rows between strokes that repeat each other


def clusters(stroke: IntVector, sign: Vector, counts: Vector, shortest: int) -> IntVector:
    """Return the number (n,) of the cluster to which each row belongs, from 0.

    Residuals of different clusters are taken as independent.

    - stroke: ascending number of the stroke of each row, (n,)
    - sign: direction of each row, (n,)
    - counts: distance between successive rows, in encoder counts, (n,)
    - shortest: number of rows over which residuals are correlated; parts of a stroke have at least
      this many rows
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


def _repetitions(sign: Vector, counts: Vector, rows: IntVector) -> IntVector:
    """Return the group number (m,) of m strokes.

    Strokes that repeat each other form a group.
    """
    order = np.lexsort((counts, rows, sign))
    # lists, because the access to single elements of an array is slow
    side, length, size = sign[order].tolist(), rows[order].tolist(), counts[order].tolist()
    group: list[int] = []
    repetitions = 0
    for stroke in range(order.size):
        found = -1
        for other in range(stroke - 1, -1, -1):
            if side[other] != side[stroke] or length[stroke] - length[other] > SAME_ROWS:
                break
            if abs(size[stroke] - size[other]) <= SAME_COUNTS:
                found = group[other]
                break
        if found < 0:
            found = repetitions
            repetitions = repetitions + 1
        group.append(found)
    out = np.empty(order.size, dtype=np.int64)
    out[order] = group
    return out
