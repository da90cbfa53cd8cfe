"""Quantisation of a signal, from the distinct values collected block after block."""

from __future__ import annotations

import numpy as np

from frictool.logs.quality.time_base import encoder_step, levels
from frictool.typing import Vector

# maximum number of distinct values collected: these suffice to show any relevant step
MOST = 1 << 17


class DistinctValues:
    """Collector of the distinct values of one signal, up to MOST values."""

    def __init__(self) -> None:
        self._values: Vector = np.empty(0)

    def take(self, values: Vector) -> None:
        """Add values (n,), all finite."""
        if self._values.size < MOST:
            self._values = np.union1d(self._values, values)

    @property
    def count(self) -> int:
        """Return the number of distinct values collected."""
        return levels(self._values) if self._values.size else 0

    @property
    def step(self) -> float | None:
        """Return the step of which all distances of values are multiples; None if there is none."""
        return encoder_step(self._values) if self._values.size else None
