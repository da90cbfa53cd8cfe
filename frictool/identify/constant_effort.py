"""Detection of strokes whose logged effort is constant although the speed varies.

The logged effort is then a saturated measurement, or a command that was logged in place of a
measurement. Coulomb friction and an offset would fit the constant effort almost exactly, with an
inertia near zero. A constant effort is valid data only

- at constant speed, which needs a constant effort;
- at several levels (an open-loop test), since one set of parameters has to explain all levels;
- at zero, since the axis coasts.

The effort of a stroke is implausible if two conditions hold. For most of the motion, the effort
stays within a narrow interval of values, here called the band. In this part of the motion, the
acceleration changes, and this change times the smallest inertia of the bench exceeds twice the
width of the band. If at least three quarters of such strokes of a direction have the same effort,
the samples with this constant effort are removed from every stroke of the direction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.polynomial.legendre import legfit

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import white_noise
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

ENDS = 0.05  # share of a stroke's travel excluded at either end, since the axis may rest there
SHORTEST = 20  # smallest number of samples in motion of a stroke that is examined
NOISE_BAND = 6.0  # width of the band, in standard deviations of the effort's noise
# least width of the band relative to the level, about the torque ripple of a drive
LEAST_BAND = 0.2
IN_BAND = 0.8  # least share of a stroke's motion inside the band
DEMAND = 2.0  # least change of the inertial effort, in widths of the band
SURE = 3.0  # standard deviations of quantisation noise subtracted from the change of acceleration
# least share of the proved strokes of a direction whose effort is within a band of their median
ONE_LEVEL = 0.75
MOST = 0.5  # share of constant effort in the motion above which a record is refused


@dataclass(frozen=True)
class ConstantStretch:
    """Samples [start, end) of a stroke with an effort in a narrow interval of values.

    - level, band: middle and width of this interval, N m | N
    - direction: direction of motion, +1 or -1
    - proved: True if the acceleration changes more than a constant effort allows
    """

    start: int
    end: int
    level: float
    band: float
    direction: float
    proved: bool


def without_constant_effort(
    records: list[MotionRecord], bench: Bench
) -> tuple[list[MotionRecord], list[str]]:
    """Return the records without samples of constant effort, and a warning for each changed record.

    Raises
    ------
    UnusableLogs
        If the effort of a record is constant for more than half of its motion.
    """
    kept, warnings = [], []
    for record in records:
        stretches, moving = constant_stretches(record, bench)
        lost = sum(stretch.end - stretch.start for stretch in stretches)
        if not lost:
            kept.append(record)
            continue
        first = min(stretches, key=lambda stretch: stretch.start)
        unit = si_unit("effort", bench.axis)
        description = (
            f"{Path(record.name).name}: the effort stays near {first.level:.4g} {unit} for "
            f"{100.0 * lost / moving:.0f} % of the motion, from {record.time[first.start]:.6g} s "
            "on, while the speed changes: it is a saturated measurement, or a command"
        )
        if lost > MOST * moving:
            raise UnusableLogs(
                f"{description}; log the measured current with a sufficient range, or use "
                "several levels of effort"
            )
        warnings.append(f"{description}; these samples are left out")
        kept.append(_without(record, stretches))
    return kept, warnings


def constant_stretches(record: MotionRecord, bench: Bench) -> tuple[list[ConstantStretch], int]:
    """Return the stretches of implausibly constant effort, and the number of samples in motion."""
    strokes = find_strokes(record)
    edges = np.flatnonzero(np.diff(strokes.number, prepend=-1, append=-1) != 0)
    noise = NOISE_BAND * white_noise(record.effort)
    inertia = bench.mechanics.inertia.interval[0]
    stretches = list[ConstantStretch]()
    moving = 0
    for start, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        travel = float(strokes.advance[end - 1])
        if strokes.sign[start] == 0.0 or travel <= 0.0:
            continue
        first, last = np.searchsorted(
            np.maximum.accumulate(strokes.advance[start:end]),
            [ENDS * travel, (1.0 - ENDS) * travel],
        )
        part = slice(start + int(first), start + int(last))
        moving += part.stop - part.start
        if part.stop - part.start < SHORTEST:
            continue
        stretch = _stretch(record, part, noise, inertia, float(strokes.sign[start]))
        if stretch is not None and abs(stretch.level) > stretch.band:
            stretches.append(stretch)
    return [
        one
        for side in (1.0, -1.0)
        for one in _of_one_level([s for s in stretches if s.direction == side])
    ], moving


def _stretch(
    record: MotionRecord, part: slice, noise: float, inertia: float, direction: float
) -> ConstantStretch | None:
    effort = record.effort[part]
    band = max(noise, LEAST_BAND * abs(float(np.median(effort))))
    level = _densest(effort, band)
    inside = np.flatnonzero(np.abs(effort - level) <= 0.5 * band)
    if inside.size < max(IN_BAND * effort.size, SHORTEST):
        return None
    first = part.start + int(inside[0])
    last = part.start + int(inside[-1]) + 1
    position = record.position[first:last]
    duration = (last - first) * record.period
    cubic = legfit(np.linspace(-1.0, 1.0, position.size), position, 3)[3]
    # standard deviation of the cubic coefficient caused by quantisation
    counts = record.resolution / np.sqrt(12.0) * np.sqrt(7.0 / position.size)
    # change of the acceleration over the stretch, rad/s^2 | m/s^2
    change = 120.0 * max(abs(float(cubic)) - SURE * counts, 0.0) / duration**2
    return ConstantStretch(first, last, level, band, direction, inertia * change > DEMAND * band)


def _densest(values: Vector, band: float) -> float:
    """Return the middle of the interval of width `band` that contains the most values."""
    ordered = np.sort(values)
    covered = np.searchsorted(ordered, ordered + band, side="right") - np.arange(ordered.size)
    best = int(np.argmax(covered))
    return 0.5 * float(ordered[best] + ordered[best + int(covered[best]) - 1])


def _of_one_level(stretches: list[ConstantStretch]) -> list[ConstantStretch]:
    """Return the stretches that have the median effort of the proved stretches.

    The result is [] if too few of the proved stretches have this effort.
    """
    proved = [stretch for stretch in stretches if stretch.proved]
    if not proved:
        return []
    middle = float(np.median([stretch.level for stretch in proved]))
    same = [stretch for stretch in stretches if abs(stretch.level - middle) <= stretch.band]
    return same if sum(stretch.proved for stretch in same) >= ONE_LEVEL * len(proved) else []


def _without(record: MotionRecord, stretches: list[ConstantStretch]) -> MotionRecord:
    keep = np.ones(record.time.size, dtype=np.bool_)
    for stretch in stretches:
        keep[stretch.start : stretch.end] = False
    index = np.flatnonzero(keep)
    piece = np.cumsum(
        (np.diff(index, prepend=index[0]) > 1)
        | (np.diff(record.piece[index], prepend=record.piece[index[0]]) > 0)
    )
    return replace(record.part(index), piece=piece.astype(np.int64))
