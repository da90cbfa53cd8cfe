"""How often moves repeat each other.

What the model misses of one of them it misses of all that are alike, so that these tell as much as
one. Two moves are alike where they have gone through the same zones: where the parts of their
friction's columns, of all of them, differ by less than ALIKE.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

ALIKE = 0.25
MOST = 60  # different moves that are kept


class MoveRepeats:
    """Takes the Gram matrices of moves."""

    def __init__(self) -> None:
        self._different: Vector | None = None
        self._counts: list[int] = []

    def take(self, gram: Vector) -> None:
        """A move more: the columns (k, k) of its friction by direction and zone."""
        sizes = np.sqrt(np.diag(gram))
        sizes = sizes / max(float(np.sqrt(sizes @ sizes)), np.finfo(float).tiny)
        if self._different is None:
            self._different, self._counts = sizes[None], [1]
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
        """Moves to a different one, 1 where none is like another."""
        return sum(self._counts) / len(self._counts) if self._counts else 1.0
