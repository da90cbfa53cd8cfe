"""What a simulated test leaves behind for its criteria: samples, and the phases of stick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Phases = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class LawTrajectory:
    """Samples (n,) in SI; `sticks`: begin and end [s] of each phase of stick, the last one may
    reach the end of the run."""

    time: Vector
    position: Vector
    velocity: Vector
    friction: Vector
    sticks: Phases

    def between(self, begin: float, end: float) -> slice:
        """The samples of begin <= t <= end."""
        first, last = np.searchsorted(self.time, (begin, end * (1.0 + 1e-12)))
        return slice(int(first), int(last))

    def at(self, t: float) -> float:
        """The position at t, between samples by a straight line."""
        return float(np.interp(t, self.time, self.position))


def slow_phases(time: Vector, velocity: Vector, threshold: float, shortest: float) -> Phases:
    """Phases of at least `shortest` [s] in which |v| < threshold: stick, as a law without exact
    stick shows it.

    A speed that passes through zero does not count: it is not slow for long.
    """
    slow = np.abs(velocity) < threshold
    edges = np.flatnonzero(np.diff(np.concatenate(([False], slow, [False])).astype(np.int8)))
    pairs = edges.reshape(-1, 2)
    last = time.size - 1
    return tuple(
        (float(time[a]), float(time[min(b, last)]))
        for a, b in pairs
        if time[min(b, last)] - time[a] >= shortest
    )
