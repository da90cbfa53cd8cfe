"""Metric entropy of the sensor (annex B): n equal counts over the travel tell ln n nats, log2 n
bits, of where the axis is.

Twice the resolution adds ln 2 whatever n is; twice the information takes n^2 counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class SensorEntropy(NamedTuple):
    """counts: n over the travel. nats: ln n. gain: what doubling n adds, relative to it. squared:
    n^2, for twice the information."""

    counts: float
    nats: float
    gain: float
    squared: float

    @property
    def bits(self) -> float:
        return self.nats / math.log(2.0)


def metric_entropy(measures: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    """(4): -sum mu ln mu over the cells of a partition, their measures (n,) summing to 1; in
    nats."""
    occupied = measures[measures > 0.0]
    return float(-(occupied * np.log(occupied)).sum())


def sensor_entropy(travel: float, step: float) -> SensorEntropy:
    """Of an encoder of `step` over `travel`, both in rad | m: (5), normalised to a travel of 1."""
    counts = travel / step
    nats = math.log(counts) if counts > 1.0 else 0.0
    return SensorEntropy(counts, nats, math.log(2.0) / nats if nats > 0.0 else math.inf, counts**2)
