"""Time from the end of a reference profile until the axis stays at its target."""

from __future__ import annotations

import math

import numpy as np

from frictool.metrics.reference_holds import MIN_SAMPLES
from frictool.metrics.reference_motion import changed_samples, find_motions
from frictool.typing import Vector

NO_REST = "the reference does not rest after a motion"


def settling_after_profile(
    time: Vector, tracked: Vector, position: Vector, settling_band: float, resolution: float
) -> float | str:
    """Return the longest settling time [s] over all motions of the reference.

    Parameters
    ----------
    time, tracked, position : Vector
        Time [s], reference and position [rad or m] of each sample, (n,).
    settling_band : float
        Largest error of a settled axis [rad or m]. If the sensor step is larger, the sensor step is
        used instead.
    resolution : float
        Step of the position sensor [rad or m], 0 if unknown.

    Returns
    -------
    float or str
        Settling time: from the end of a motion until |error| no longer exceeds `settling_band`. The
        time is infinite if |error| exceeds `settling_band` when the next motion begins. If no
        motion is followed by 20 samples of constant reference, the result is a reason as text.
    """
    changes = np.append(changed_samples(tracked), tracked.size - 1)
    band = max(settling_band, resolution) * (1.0 + 1e-9)
    durations = []
    for _, stop in find_motions(tracked):
        last = int(changes[np.searchsorted(changes, stop)])
        if last - stop + 1 < MIN_SAMPLES:
            continue
        outside = np.flatnonzero(np.abs(tracked - position)[stop : last + 1] > band)
        first = stop if not outside.size else stop + int(outside[-1]) + 1
        durations.append(math.inf if first > last else float(time[first] - time[stop]))
    return max(durations) if durations else NO_REST
