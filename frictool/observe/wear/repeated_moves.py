"""Number of moves that are similar to each other.

Similar moves have the same model errors, so that a group of similar moves is treated as one move.
Two moves are similar if their normalised friction columns differ by less than ALIKE, for
example because the moves pass through the same zones.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector

ALIKE = 0.25  # largest Euclidean distance of the normalised friction columns of similar moves
MOST = 60  # largest number of different moves that are kept


class MoveRepeats:
    """Counter of similar moves, from their Gram matrices."""

    def __init__(self) -> None:
        self._different: Vector | None = None
        self._counts: list[int] = []

    def take(self, gram: Vector) -> None:
        """Add a move; `gram` (k, k) is the Gram matrix of the move's k columns of dry friction."""
        sizes = np.sqrt(np.diag(gram))
        sizes = sizes / max(float(np.sqrt(sizes @ sizes)), np.finfo(float).tiny)
        if self._different is None:
            self._different = sizes[None]
            self._counts = [1]
            return
        off = np.sum((self._different - sizes) ** 2, axis=1)
        nearest = int(np.argmin(off))
        if off[nearest] < ALIKE**2:
            self._counts[nearest] += 1
        else:
            self._different = np.concatenate([self._different[-MOST + 1 :], sizes[None]])
            self._counts = [*self._counts[-MOST + 1 :], 1]

    @property
    def each(self) -> float:
        """Return the mean number of moves in a group of similar moves; 1 if none are similar."""
        return sum(self._counts) / len(self._counts) if self._counts else 1.0
