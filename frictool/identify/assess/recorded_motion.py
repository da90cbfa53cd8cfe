"""Motion of a record as input of `assess`, in place of the motion of a proposed test.

Each stroke of a record is treated as a half sine with the same distance and duration. A record with
many strokes is represented by MOST strokes, evenly spaced in the order of their durations.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.assess.assessment_inputs import (
    AssessmentInputs,
    known_widths,
    time_constants,
)
from frictool.identify.excite.bench_limits import axis_known
from frictool.identify.excite.cramer_rao import PlannedStroke, SensorPrecision
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import (
    FOURTH_DIFFERENCE_GAIN,
    fourth_difference_power,
    position_noise,
)
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

MOST = 8  # largest number of strokes that represent a record


def recorded_facts(records: list[MotionRecord], bench: Bench) -> AssessmentInputs:
    """Return the inputs of an assessment for records of sliding motion.

    Raises UnusableLogs if the axis never moves.
    """
    stroke_table = np.concatenate([_strokes(record) for record in records])
    if stroke_table.size == 0:
        raise UnusableLogs(
            "the axis never moves by more than one encoder count; record longer strokes"
        )
    strokes = _representatives(stroke_table)
    known = bench.mechanics
    fastest, slowest = time_constants(bench)
    noise = (
        math.sqrt(max(fourth_difference_power(record.effort) for record in records))
        / FOURTH_DIFFERENCE_GAIN
    )
    step = max(position_noise(record) for record in records) * math.sqrt(12.0)
    return AssessmentInputs(
        axis=axis_known(bench),
        sensing=SensorPrecision(max(record.period for record in records), step, noise),
        speed=max(stroke.speed for stroke in strokes),
        effort=max(float(np.max(np.abs(record.effort))) for record in records),
        strokes=strokes,
        fastest=fastest,
        slowest=slowest,
        known=known_widths(bench),
        inertia=(known.inertia.interval[0], known.inertia.value, known.inertia.interval[1]),
    )


def _strokes(record: MotionRecord) -> Vector:
    strokes = find_strokes(record)
    moving = strokes.sign != 0.0
    number, advance = strokes.number[moving], strokes.advance[moving]
    starts = np.flatnonzero(np.diff(number, prepend=-1))
    if starts.size == 0:
        return np.empty((0, 2))
    lengths = np.diff(np.append(starts, number.size))
    return np.column_stack((lengths * record.period, np.maximum.reduceat(advance, starts)))


def _representatives(strokes: Vector) -> tuple[PlannedStroke, ...]:
    """Return at most MOST of the m rows (duration, distance) of `strokes`.

    The rows are evenly spaced in the order of their durations.
    """
    order = strokes[np.argsort(strokes[:, 0], kind="stable")]
    count = min(MOST, order.shape[0])
    chosen = order[((np.arange(count) + 0.5) * order.shape[0] / count).astype(np.int64)]
    times = order.shape[0] / (2.0 * count)
    return tuple(
        PlannedStroke(0.5 * math.pi * float(distance) / float(time), float(distance), times)
        for time, distance in chosen
    )
