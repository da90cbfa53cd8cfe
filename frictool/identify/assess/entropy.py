"""Metric entropy of the sensor (thesis, annex B).

A position sensor with n equal counts over the travel has the entropy ln n nats, or log2 n bits.
Doubling the resolution adds ln 2 nats.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class SensorEntropy(NamedTuple):
    """Entropy of a position sensor.

    - counts: number n of counts over the travel
    - nats: ln n
    - gain: relative increase of the entropy if n doubles
    - squared: n^2, the number of counts of an encoder with twice the entropy
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
    """Return the entropy -sum(p ln p) [nats] of cells with relative sizes p = `measures`, (n,)."""
    occupied = measures[measures > 0.0]
    return float(-(occupied * np.log(occupied)).sum())


def sensor_entropy(travel: float, step: float) -> SensorEntropy:
    """Return the entropy of an encoder (thesis, annex B, equation 5).

    `travel` and `step` have the same unit, rad | m.
    """
    counts = travel / step
    nats = math.log(counts) if counts > 1.0 else 0.0
    return SensorEntropy(counts, nats, math.log(2.0) / nats if nats > 0.0 else math.inf, counts**2)
