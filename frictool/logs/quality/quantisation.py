"""The values that a signal takes, gathered block after block: their step is the quantisation of
what measured it."""

from __future__ import annotations

import numpy as np

from frictool.logs.log import Vector
from frictool.logs.quality.time_base import encoder_step, levels

MOST = (
    1 << 17
)  # distinct values kept: what takes more lies on no lattice that matters, or shows it in these


class DistinctValues:
    """Distinct values of one signal, the first MOST of them."""

    def __init__(self) -> None:
        self._values: Vector = np.empty(0)

    def take(self, values: Vector) -> None:
        """Adds values (n,), finite."""
        if self._values.size < MOST:
            self._values = np.union1d(self._values, values)

    @property
    def count(self) -> int:
        """How many values were taken, at least."""
        return levels(self._values) if self._values.size else 0

    @property
    def step(self) -> float | None:
        """The step of the lattice on which they lie, or None."""
        return encoder_step(self._values) if self._values.size else None
