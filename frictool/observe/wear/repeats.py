"""How often moves repeat each other.

What the model misses of one of them it misses of all that are alike, so that these tell as much as one. Two moves are alike where they have
gone through the same zones: where the parts of their friction's columns, of all of them, differ by less than ALIKE.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

ALIKE = 0.25
MOST = 60  # different moves that are kept


class Repeats:
    """Takes the Gram matrices of moves."""

    def __init__(self) -> None:
        self._kinds: list[Vector] = []
        self._counts: list[int] = []

    def take(self, gram: Vector) -> None:
        """A move more: the columns (k, k) of its friction by direction and zone."""
        sizes = np.sqrt(np.diag(gram))
        sizes = sizes / max(float(np.linalg.norm(sizes)), np.finfo(float).tiny)
        for place, kind in enumerate(self._kinds):
            if float(np.linalg.norm(sizes - kind)) < ALIKE:
                self._counts[place] += 1
                return
        self._kinds, self._counts = [*self._kinds[-MOST + 1 :], sizes], [*self._counts[-MOST + 1 :], 1]

    @property
    def each(self) -> float:
        """Moves to a different one, 1 where none is like another."""
        return sum(self._counts) / len(self._counts) if self._counts else 1.0
