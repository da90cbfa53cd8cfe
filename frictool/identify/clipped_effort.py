"""Find an effort whose sensor clips below what the axis needs, although noise after the clipping hides the flat tops.

Samples pile up within the noise of one level, and none lie above it. An axis at constant speed gives such a level, too, so that the motion
decides: a model without the samples at the level is fitted to the others, and predicts the effort that the motion needs at the level. A
clipped effort is exceeded by it in nearly every stroke. Choosing samples by their effort has the opposite effect on an effort that was
measured: at its top the errors are positive, and the prediction lies below.

Flat tops without noise are found in `refusals.py`, an effort that is constant for most of the motion in `constant_effort.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.constant_effort import densest, effort_noise
from frictool.identify.held_effort import columns_of
from frictool.identify.methods import Settings
from frictool.identify.outcome import NothingUsable
from frictool.identify.record import Record, Vector
from frictool.identify.refusals import AT_THE_LIMIT
from frictool.identify.rows.samples import Samples
from frictool.identify.rows.slipping import SMALLEST_SHARE, slipping
from frictool.identify.rows.strokes import find_strokes

TOP = 0.995  # quantile of the effort near which a level is searched for
BAND = 4.0  # standard deviations of the noise on either side of the level
MEAN_OVER = 5  # samples, by which the noise is reduced before a sample is said to be at the level
LEAST_SHARE = 0.02  # of the samples in motion that are at the level
SHARPNESS = 0.02  # samples above the band, relative to those in it
EXCESS = 3.0  # least mean of the predicted effort beyond the level, in rms residuals of the other samples
FEWEST_STROKES = 3  # strokes with samples at the level
NEARLY_ALL = 0.8  # share of these strokes in which the prediction exceeds the level
MOST_SAMPLES = 200_000  # of a record that are looked at


@dataclass(frozen=True)
class ClippingLevel:
    """Level in N m | N, share of the samples in motion that are at it, mean of the effort that the motion needs there, first time in s."""

    level: float
    share: float
    needed: float
    time: float


def refuse_clipped_effort(records: list[Record], bench: Bench, settings: Settings) -> None:
    """Raise NothingUsable if the measurement of the effort of a record clips."""
    for record in records:
        found = clipping_level(record, bench, settings)
        if found is not None:
            unit = si_unit("effort", bench.axis)
            raise NothingUsable(
                f"{Path(record.name).name}: the effort goes no further than {found.level:.4g} {unit} for {100.0 * found.share:.2g} % of "
                f"the motion, from {found.time:.6g} s on, where the motion needs {found.needed:.4g} {unit}: its measurement clips; "
                "widen its range"
            )


def clipping_level(record: Record, bench: Bench, settings: Settings) -> ClippingLevel | None:
    """Return the level at which the effort clips, or None."""
    record = record.part(slice(0, MOST_SAMPLES))
    noise = effort_noise(record.effort)
    most = bench.actuator.limit.value * bench.actuator.constant.value
    if noise == 0.0:
        return None
    piles = {side: _pile(side * record.effort, noise) for side in (1.0, -1.0)}
    sides = {side: level for side, level in piles.items() if level is not None and level < AT_THE_LIMIT * most}
    if not sides:
        return None
    mean = np.convolve(record.effort, np.full(MEAN_OVER, 1.0 / MEAN_OVER), mode="same")
    at_level = {side: side * mean > level - noise for side, level in sides.items()}
    try:
        rows, window = slipping([record], bench, SMALLEST_SHARE, settings.window)
        touched = {side: _share_of_window(record, bench, settings, at) for side, at in at_level.items()}
        values, residual = _fitted(rows, np.max(list(touched.values()), axis=0) < 0.5 / window)
    except NothingUsable:
        return None
    excess = columns_of(rows) @ values - rows.effort
    for side, at in at_level.items():
        chosen = touched[side] > 0.5
        if _clipped(side * excess[chosen], rows.stroke[chosen], residual):
            level = float(np.mean(rows.effort[chosen]))
            share = np.count_nonzero(at) / np.count_nonzero(find_strokes(record).sign)
            return ClippingLevel(level, share, level + float(np.mean(excess[chosen])), float(record.time[np.argmax(at)]))
    return None


def _share_of_window(record: Record, bench: Bench, settings: Settings, at: NDArray[np.bool_]) -> Vector:
    """Return the share of the samples `at` (n,) in the smoothing window of each row."""
    return slipping([replace(record, effort=at.astype(np.float64))], bench, SMALLEST_SHARE, settings.window)[0].effort


def _pile(effort: Vector, noise: float) -> float | None:
    """Return the level at the top of an effort (n,) in which samples pile up within the noise; None without one."""
    near = effort[effort > float(np.quantile(effort, TOP)) - 2.0 * BAND * noise]
    level = densest(near, BAND * noise)
    inside = np.count_nonzero(np.abs(effort - level) <= BAND * noise)
    above = np.count_nonzero(effort > level + BAND * noise)
    return level if level > 0.0 and inside >= LEAST_SHARE * effort.size and above <= SHARPNESS * inside else None


def _fitted(rows: Samples, free: NDArray[np.bool_]) -> tuple[Vector, float]:
    """Return the parameters fitted to the rows that are `free` (n,), and the residual's rms. Raises NothingUsable if they are too few."""
    columns = columns_of(rows)
    if np.count_nonzero(free) < 10 * columns.shape[1]:
        raise NothingUsable("too few samples are below the level")
    values, _, rank, _ = np.linalg.lstsq(columns[free], rows.effort[free], rcond=None)
    if rank < columns.shape[1]:
        raise NothingUsable("the samples below the level do not excite every parameter")
    return np.asarray(values), float(np.sqrt(np.mean((rows.effort[free] - columns[free] @ values) ** 2)))


def _clipped(excess: Vector, stroke: NDArray[np.int64], residual: float) -> bool:
    """Return whether the motion needs more than the level; excess (n,) of the rows at it, stroke (n,) numbers."""
    strokes = np.unique(stroke)
    means = np.array([float(np.mean(excess[stroke == one])) for one in strokes])
    return strokes.size >= FEWEST_STROKES and bool(np.mean(means > 0.0) >= NEARLY_ALL and np.mean(excess) > EXCESS * residual)
