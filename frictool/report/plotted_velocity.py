"""The velocity that is plotted: the log's own, or the sensor's difference over as few samples as
make it readable."""

from __future__ import annotations

import numpy as np

from frictool.logs.log import Stream, Vector
from frictool.presentation.decimation import finite_or_nan

LEAST_LEVELS = 40  # sensor steps at top speed
MOST_SAMPLES = 40


def shown_velocity(stream: Stream, resolution: float) -> tuple[Vector, str] | None:
    """Velocity (n,) in rad/s or m/s and where it comes from; None without a velocity and a
    position.

    resolution: the position sensor's step [rad or m].
    """
    if "velocity" in stream.signals:
        return finite_or_nan(stream.signals["velocity"]), "velocity in the log"
    time = stream.time
    if "position" not in stream.signals or time.size < 2:
        return None
    position = finite_or_nan(stream.signals["position"])
    samples = _samples(position, resolution)
    slopes = (position[samples:] - position[:-samples]) / (time[samples:] - time[:-samples])
    # each slope belongs to all samples that it spans; a sample has the mean of its slopes
    ones = np.ones(samples + 1)
    difference = np.convolve(slopes, ones) / np.convolve(np.ones(slopes.size), ones)
    span = samples * stream.period
    return difference, f"position difference over {span * 1e3:.3g} ms" + (
        ", averaged" if samples > 1 else ""
    )


def used_velocity(stream: Stream, simulated: bool) -> tuple[Vector, Vector] | str:
    """What the controller took for the speed and the true one, (n,) each, or why there is none to
    compare."""
    if not simulated:
        return "only a simulated log knows the true velocity"
    missing = [name for name in ("velocity_estimated", "velocity") if name not in stream.signals]
    if missing:
        return (
            f"the log has no {missing[0]}: its controller asks for no speed, or has a sensor of it"
        )
    return stream.signals["velocity_estimated"], stream.signals["velocity"]


def _samples(position: Vector, resolution: float) -> int:
    """How many samples apart the difference is taken, so that it shows at least 40 levels where the
    sensor allows it."""
    for samples in range(1, min(MOST_SAMPLES, position.size - 1)):
        if (
            float(np.max(np.abs(position[samples:] - position[:-samples])))
            >= LEAST_LEVELS * resolution
        ):
            return samples
    return min(MOST_SAMPLES, position.size - 1)
