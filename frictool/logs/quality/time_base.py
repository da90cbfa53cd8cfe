"""Time base of a log (rate, jitter, gaps) and quantisation step of an encoder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.typing import Vector

# longest interval without a missing sample, in periods; the time stamps of a regular clock may be
# rounded to half a period
GAP = 1.5 * (1.0 + 1e-6)
# relative difference between the periods of log and bench above which there is a warning
RATE_NOTED = 0.01
# least share of equally long runs of equal times, and largest difference of their lengths
EQUAL_RUNS = 0.9
RUN_DIFFERENCE = 0.1
FEWEST_LEVELS = 8  # least number of distinct positions for an estimate of the step
MOST_STEPS = 8  # largest allowed distance between the two nearest distinct positions, in steps
ON_LATTICE = 0.05  # largest deviation of a position from a multiple of the step, in steps


@dataclass(frozen=True)
class TimeBase:
    """Sample rate, jitter and gaps of a stream.

    rate_hz: inverse of the median interval, in Hz.
    jitter_s: standard deviation in s of the intervals that are not gaps.
    gaps: number of intervals in which a sample is missing.
    longest_gap_s: longest gap in s.
    duration_s: time from the first to the last sample, in s.
    """

    samples: int
    rate_hz: float
    jitter_s: float
    gaps: int
    longest_gap_s: float
    duration_s: float


def time_base(time: Vector) -> TimeBase:
    """Return rate, jitter and gaps of strictly increasing times (n,) in s.

    Rate and jitter are NaN if there is only one sample.
    """
    if time.size < 2:
        return TimeBase(int(time.size), float("nan"), float("nan"), 0, 0.0, 0.0)
    intervals = np.diff(time)
    period = float(np.median(intervals))
    is_gap = intervals > GAP * period
    gaps = int(is_gap.sum())
    longest = float(intervals[is_gap].max()) if gaps else 0.0
    return TimeBase(
        time.size,
        1.0 / period,
        float(intervals[~is_gap].std()),
        gaps,
        longest,
        float(time[-1] - time[0]),
    )


def coarse_period(time: Vector) -> tuple[float, float] | None:
    """Return (period, error) of equidistant rows whose logged times are rounded.

    Several successive rows then have the same time, for example if a logger writes whole seconds.

    time: times (n,) that never decrease. Period and error have the unit of `time`. The result is
        None if fewer than two runs of equal times are complete, or if the runs are not equally
        long.
    """
    changes = np.flatnonzero(np.diff(time)) + 1
    if changes.size < 3 or np.any(np.diff(time) < 0):
        return None
    rows = np.diff(changes)
    usual = float(np.median(rows))
    equal = np.abs(rows - usual) <= max(1.0, RUN_DIFFERENCE * usual)
    if usual < 2.0 or np.mean(equal) < EQUAL_RUNS:
        return None
    count = int(rows[equal].sum())
    period = float(np.diff(time[changes])[equal].sum()) / count
    return period, period / count


def levels(position: Vector) -> int:
    """Return the number of distinct values among the positions (n,)."""
    return int(_distances(position).size) + 1


def _distances(position: Vector) -> Vector:
    """Sort the distinct values and return the differences of successive values.

    Values that differ only by rounding count as one value.
    """
    # drop repeated samples, so that a resting axis needs no sorting
    changed = np.append(True, position[1:] != position[:-1])
    values = np.sort(position[changed])
    distances = np.diff(values)
    return np.asarray(distances[distances > 16 * np.spacing(np.abs(values).max())])


def encoder_step(position: Vector) -> float | None:
    """Return the encoder step: all distances between the positions (n,) are multiples of this step.

    The step is the smallest distance of two positions divided by a number up to MOST_STEPS. The
    result is None if no such step fits, or if there are too few distinct positions.
    """
    distances = np.sort(_distances(position))
    if distances.size < FEWEST_LEVELS - 1:
        return None
    steps = (_step(distances, parts) for parts in range(1, MOST_STEPS + 1))
    return next((step for step in steps if step is not None), None)


def _step(distances: Vector, parts: int) -> float | None:
    """Return the step near the smallest distance divided by `parts`; None if no such step fits.

    The positions may be rounded, as in a text file. The step is therefore determined from the
    shortest of the sorted distances first, and is then refined with longer and longer distances.
    """
    step = float(distances[0]) / parts
    longest = parts
    while True:
        near = distances[: np.searchsorted(distances, (longest + 0.5) * step)]
        steps = np.rint(near / step)
        if np.abs(near / step - steps).max() >= ON_LATTICE:
            return None
        step = float(near.sum() / steps.sum())
        if near.size == distances.size:
            return step
        longest *= 2
