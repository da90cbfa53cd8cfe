"""What a log's samples say about the instrument: rate, jitter, gaps, the step of the encoder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.logs.log import Vector

GAP = 1.5  # periods: a longer interval has lost a sample
FEWEST_LEVELS = 8  # distinct positions below which no step is read from them
MOST_STEPS = 8  # the two nearest positions seen may be up to this many steps apart
ON_LATTICE = 0.05  # steps


@dataclass(frozen=True)
class TimeBase:
    """samples; rate in Hz, of the median period; jitter in s, the standard deviation of the
    intervals that are no gaps; gaps; span in s."""

    samples: int
    rate_hz: float
    jitter_s: float
    gaps: int
    longest_gap_s: float
    duration_s: float


def time_base(time: Vector) -> TimeBase:
    """The quality of strictly increasing times (n,) in s. With one sample, rate and jitter are
    NaN."""
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


def levels(position: Vector) -> int:
    """How many values the positions (n,) take."""
    return int(_distances(position).size) + 1


def _distances(position: Vector) -> Vector:
    """Between neighbouring values that were seen, ascending; equal counts may be unequal by
    rounding, and are one value."""
    values = np.unique(position)
    distances = np.diff(values)
    return np.asarray(distances[distances > 16 * np.spacing(np.abs(values).max())])


def encoder_step(position: Vector) -> float | None:
    """The step of which all positions (n,) are multiples, up to a common offset; None where they
    lie on no lattice.

    Neighbouring positions that were seen may be several steps apart: the step is the largest whole
    fraction of their smallest distance of which every distance is a multiple.
    """
    distances = _distances(position)
    if distances.size < FEWEST_LEVELS - 1:
        return None
    for parts in range(1, MOST_STEPS + 1):
        step = distances.min() / parts
        steps = np.rint(distances / step)
        if np.abs(distances / step - steps).max() < ON_LATTICE:
            return float(distances.sum() / steps.sum())
    return None
