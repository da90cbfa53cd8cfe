"""Time for which the drive is at its limit."""

from __future__ import annotations

import numpy as np

from frictool.metrics.sample_durations import sample_durations
from frictool.typing import Vector

# relative tolerance of a limited command, which the controller's processor or the log may round
AT_LIMIT = 1e-3
NEAR_LIMIT = 0.01  # relative tolerance of a measured drive, for its lag and gain error


def commanded_saturation(time: Vector, command: Vector, limit: float) -> float:
    """Return the time [s] for which |command| (n,) [A | V] is at its `limit`.

    The command counts as constant between two samples. `time`: (n,) [s].
    """
    return _total(time, command, limit * (1.0 - AT_LIMIT))


def measured_saturation(time: Vector, drive: Vector, limit: float, deviation: float) -> float:
    """Return the time [s] for which a measured |drive| (n,) [A | V] is at its `limit`.

    The drive counts as limited if |drive| >= limit - max(1 % of the limit, 2 `deviation`).
    `deviation` is the standard deviation of the drive's white noise.
    """
    return _total(time, drive, limit - max(NEAR_LIMIT * limit, 2.0 * deviation))


def saturation_time(
    time: Vector,
    command: Vector | None,
    measured: Vector | None,
    drive_limit: float,
    drive_noise: float,
) -> float:
    """Return the time [s] for which the drive (n,) [A | V] is at its limit.

    The drive is `command` or, if that is None, `measured`. `drive_noise` is the standard deviation
    of the noise on `measured`.
    """
    if command is not None:
        return commanded_saturation(time, command, drive_limit)
    assert measured is not None
    return measured_saturation(time, measured, drive_limit, drive_noise)


def _total(time: Vector, drive: Vector, level: float) -> float:
    return float(np.sum(sample_durations(time)[np.abs(drive) >= level]))
