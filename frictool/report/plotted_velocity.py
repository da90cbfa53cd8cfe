"""Velocity for plots: the logged velocity, or differences of the position over several samples."""

from __future__ import annotations

import numpy as np

from frictool.logs.log import Stream
from frictool.presentation.decimation import finite_or_nan
from frictool.typing import Vector

LEAST_LEVELS = 40  # smallest position difference at top speed, in sensor steps
MOST_SAMPLES = 40


def shown_velocity(stream: Stream, resolution: float) -> tuple[Vector, str] | None:
    """Return (velocity (n,) [rad/s | m/s], text on its source); None if it is unknown.

    `resolution`: step of the position sensor [rad | m].
    """
    if "velocity" in stream.signals:
        return finite_or_nan(stream.signals["velocity"]), "velocity in the log"
    time = stream.time
    if "position" not in stream.signals or time.size < 2:
        return None
    position = finite_or_nan(stream.signals["position"])
    samples = _samples(position, resolution)
    slopes = (position[samples:] - position[:-samples]) / (time[samples:] - time[:-samples])
    # the velocity at a sample is the mean of all slopes over intervals that contain the sample
    ones = np.ones(samples + 1)
    difference = np.convolve(slopes, ones) / np.convolve(np.ones(slopes.size), ones)
    span = samples * stream.period
    return difference, f"position difference over {span * 1e3:.3g} ms" + (
        ", averaged" if samples > 1 else ""
    )


def used_velocity(stream: Stream, simulated: bool) -> tuple[Vector, Vector] | str:
    """Return (speed (n,) that the controller used, true speed (n,)), or why one is missing."""
    if not simulated:
        return "only a simulated log contains the true velocity"
    missing = [name for name in ("velocity_estimated", "velocity") if name not in stream.signals]
    if missing:
        return (
            f"the log has no {missing[0]}: its controller uses no speed, or measures it by a sensor"
        )
    return stream.signals["velocity_estimated"], stream.signals["velocity"]


def _samples(position: Vector, resolution: float) -> int:
    for samples in range(1, min(MOST_SAMPLES, position.size - 1)):
        if (
            float(np.max(np.abs(position[samples:] - position[:-samples])))
            >= LEAST_LEVELS * resolution
        ):
            return samples
    return min(MOST_SAMPLES, position.size - 1)
