"""The velocity that is plotted: the log's own, or the sensor's difference over as few samples as make it readable."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from frictool.logs.log import Vector

if TYPE_CHECKING:
    from frictool.report.evidence import Evidence

LEAST_LEVELS = 40  # sensor steps at top speed
MOST_SAMPLES = 40


def shown_velocity(evidence: Evidence) -> tuple[Vector, str] | None:
    """Velocity (n,) in rad/s or m/s and where it comes from; None without a velocity and a position."""
    if evidence.has("velocity"):
        return evidence.plotted("velocity"), "velocity in the log"
    time = evidence.stream.time
    if not evidence.has("position") or time.size < 2:
        return None
    position = evidence.plotted("position")
    samples = _samples(position, evidence.resolution)
    slopes = (position[samples:] - position[:-samples]) / (time[samples:] - time[:-samples])
    # each slope belongs to all samples that it spans; a sample has the mean of its slopes
    ones = np.ones(samples + 1)
    difference = np.convolve(slopes, ones) / np.convolve(np.ones(slopes.size), ones)
    span = samples * evidence.stream.period
    return difference, f"position difference over {span * 1e3:.3g} ms" + (", averaged" if samples > 1 else "")


def used_velocity(evidence: Evidence) -> tuple[Vector, Vector] | str:
    """What the controller took for the speed and the true one, (n,) each, or why there is none to compare."""
    if not evidence.simulated:
        return "only a simulated log knows the true velocity"
    missing = [name for name in ("velocity_estimated", "velocity") if not evidence.has(name)]
    if missing:
        return f"the log has no {missing[0]}: its controller asks for no speed, or has a sensor of it"
    return evidence.stream.signals["velocity_estimated"], evidence.stream.signals["velocity"]


def _samples(position: Vector, resolution: float) -> int:
    """How many samples apart the difference is taken, so that it shows at least 40 levels where the sensor allows it."""
    for samples in range(1, min(MOST_SAMPLES, position.size - 1)):
        if float(np.max(np.abs(position[samples:] - position[:-samples]))) >= LEAST_LEVELS * resolution:
            return samples
    return min(MOST_SAMPLES, position.size - 1)
