"""Trajectory of a simulated test: samples and stick phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.typing import Vector

Phases = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class LawTrajectory:
    """Samples of a simulated test.

    - time, position, velocity, friction: samples (n,) in SI
    - sticks: start and end [s] of each stick phase; the last phase may reach the end of the run
    """

    time: Vector
    position: Vector
    velocity: Vector
    friction: Vector
    sticks: Phases

    def between(self, begin: float, end: float) -> slice:
        """Return the slice of the samples with begin <= t <= end."""
        first, last = np.searchsorted(self.time, (begin, end * (1.0 + 1e-12)))
        return slice(int(first), int(last))

    def at(self, t: float) -> float:
        """Return the position at t by linear interpolation."""
        return float(np.interp(t, self.time, self.position))


def slow_phases(time: Vector, velocity: Vector, threshold: float, shortest: float) -> Phases:
    """Return the phases of at least `shortest` [s] in which |velocity| is below `threshold`.

    For a law under which the mass is never exactly at rest, these are the stick phases. `threshold`
    is in m/s | rad/s. `shortest` excludes zero crossings of the velocity.
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
