"""Metric entropy of the sensor (annex B).

n equal counts over the travel hold ln n nats, or log2 n bits, of information on the position. Twice
the resolution adds ln 2 for any n; twice the information needs n^2 counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class SensorEntropy(NamedTuple):
    """Entropy of a position sensor.

    - counts: number n of counts over the travel
    - nats: ln n
    - gain: relative gain from doubling n
    - squared: n^2, the counts for twice the information
    """

    counts: float
    nats: float
    gain: float
    squared: float

    @property
    def bits(self) -> float:
        """Return the entropy in bits."""
        return self.nats / math.log(2.0)


def metric_entropy(measures: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """Return the entropy (4) of a partition, -sum mu ln mu, in nats.

    `measures` (n,) are the measures of the cells; their sum is 1.
    """
    occupied = measures[measures > 0.0]
    return float(-(occupied * np.log(occupied)).sum())


def sensor_entropy(travel: float, step: float) -> SensorEntropy:
    """Return the entropy (5) of an encoder of `step` over `travel`, both in rad | m."""
    counts = travel / step
    nats = math.log(counts) if counts > 1.0 else 0.0
    return SensorEntropy(counts, nats, math.log(2.0) / nats if nats > 0.0 else math.inf, counts**2)
