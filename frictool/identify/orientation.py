"""Check that position and drive have the same positive direction.

If the position or the drive of a log is negated, the fitted inertia and friction are negative. The
check fits the following model to the samples of a log at which the axis certainly slips:

    effort = inertia a + friction sign(v) + offset + declared loads

Here a is the acceleration and v the velocity. The inertial effort (inertia times rms acceleration)
is compared with the friction. Position and drive have opposite directions if the larger of the two
efforts, in absolute value, is significantly negative. The smaller effort is ignored, since a delay
between position and drive can change the sign of a small effort.

Some logs do not allow this fit, for example breakaway ramps or slow motion with a coarse encoder.
In these logs, the strokes are tested: the mean effort from the first to the last encoder change of
a stroke is friction plus offset.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.name_list import listed
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.regression_samples import FEWEST_STROKES, parameters_of
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.sign_check import CLEAR, net_work, reversal, reversed_signal
from frictool.typing import Vector

# the drive does not move the axis if it overcomes less friction than this, relative to the smallest
# Coulomb friction of the bench
WEAK = 0.5
OPPOSITE = "position and drive have opposite signs"  # part of each message about signs


def reversed_sign(
    records: Sequence[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> str | None:
    """Return a message if position and drive of a record have opposite signs, else None."""
    for record in records:
        shown = _negative_effort(record, bench, settings)
        if shown is not None:
            return undriven(record, bench, settings.confidence) or opposite_signs(
                [record], shown, bench
            )
    return None


def undriven(record: MotionRecord, bench: Bench, confidence: float) -> str | None:
    """Return a message if the effort of a record cannot overcome the friction, else None.

    Half the difference of the mean efforts forward and backward is the friction that the drive
    overcomes; a load cancels in this difference. The message is returned if the magnitude of this
    friction is significantly below WEAK times the smallest Coulomb friction of the bench, and if
    the rms deviation of the effort from its median is below the smallest Coulomb friction. The
    message is not returned if the friction is significantly positive, because the effort may have a
    wrong unit.
    """
    found = stroke_friction(*stroke_efforts(record), confidence)
    least = bench.mechanics.coulomb.interval[0]
    size = float(np.sqrt(np.mean((record.effort - np.median(record.effort)) ** 2)))
    if found is None or found.low > 0.0 or size >= least:
        return None
    if max(-found.low, found.high) >= WEAK * least:
        return None
    return (
        f"{Path(record.name).name}: the drive overcomes a friction of {abs(found.value):.2g} "
        f"{si_unit('effort', bench.axis)} (bench: at least {least:.3g}); another force moves the "
        "axis, or the drive was off"
    )


def negative_effort(records: Sequence[MotionRecord], bench: Bench, confidence: float) -> str | None:
    """Return a message if the effort of a record opposes its motion, else None.

    With enough strokes in both directions, the effort opposes the motion if the mean effort along
    the strokes minus the offset is significantly negative. With fewer strokes, the mean effort
    along every stroke and the net work of the effort must be negative.
    """
    for record in records:
        direction, effort = stroke_efforts(record)
        friction = stroke_friction(direction, effort, confidence)
        work = net_work(record.position, record.effort)
        if friction is not None and friction.high < 0.0:
            shown = (
                f"{friction.value:.4g} {si_unit('effort', bench.axis)} in [{friction.low:.4g}, "
                f"{friction.high:.4g}]"
            )
            return undriven(record, bench, confidence) or opposite_signs(
                [record], f"the mean effort along its strokes is {shown}", bench
            )
        if (
            friction is None
            and direction.size
            and np.all(direction * effort < 0.0)
            and work is not None
            and work <= -CLEAR
        ):
            return opposite_signs(
                [record],
                f"the net work of the effort, sum F dx, is {100.0 * work:.0f} % of sum |F dx|",
                bench,
            )
    return None


def stroke_efforts(record: MotionRecord) -> tuple[Vector, Vector]:
    """Return the direction (+1 or -1) and the mean effort [N m | N] of each stroke, each (s,).

    The mean is taken from the first to the last encoder change of the stroke.
    """
    strokes = find_strokes(record)
    direction, effort = list[float](), list[float]()
    starts = np.flatnonzero(np.diff(strokes.number, prepend=-1))
    for first, end in itertools.pairwise([*starts.tolist(), record.position.size]):
        advance = strokes.advance[first:end]
        begin = int(np.argmax(advance > 0.0))
        last = int(np.argmax(advance))
        if strokes.sign[first] != 0.0 and last > begin:
            direction.append(float(strokes.sign[first]))
            effort.append(float(np.mean(record.effort[first + begin : first + last])))
    return np.array(direction), np.array(effort)


def stroke_friction(direction: Vector, effort: Vector, confidence: float) -> Interval | None:
    """Return the mean effort in the direction of motion, without offset, N m | N.

    `direction` (s,) is +1 or -1, and `effort` (s,) is the mean effort of each stroke. Return None
    if there are too few strokes in one direction.
    """
    if min(np.count_nonzero(direction > 0.0), np.count_nonzero(direction < 0.0)) < FEWEST_STROKES:
        return None
    columns = np.column_stack((direction, np.ones(direction.size)))
    solution = solve(columns, effort, np.ones(direction.size), np.arange(direction.size))
    value = float(solution.value[0])
    half = float(solution.half_width(confidence)[0])
    return Interval.around(value, half)


def opposite_signs(records: Sequence[MotionRecord], shown: str, bench: Bench) -> str:
    """Return a message about opposite signs: names of the logs, evidence, and remedy.

    `shown` is the evidence as text.
    """
    wrong = reversed_signal("effort", records[0].position, records[0].reference)
    return (
        f"{listed([Path(record.name).name for record in records])}: {OPPOSITE}: {shown}; "
        f"{reversal(wrong, bench)} and ingest again"
    )


def _negative_effort(
    record: MotionRecord, bench: Bench, settings: IdentificationSettings
) -> str | None:
    """Return a text that states the negative inertia or friction of a record; None without one."""
    try:
        samples, window = slipping([record], bench, SMALLEST_SHARE, settings.window)
        if "coulomb" in parameters_of(samples)[1]:
            return None  # one direction or too few strokes: the friction could be an offset
    except UnusableLogs:
        return None
    columns = np.column_stack(
        (samples.acceleration, samples.sign, np.ones(samples.sign.size), *samples.loads.values())
    )
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    try:
        solution = solve(columns, samples.effort, np.ones(samples.sign.size), cluster)
    except SingularRegressors:
        return None
    value = solution.value
    half = solution.half_width(settings.confidence)
    inertial = abs(value[0]) * float(np.sqrt(np.mean(samples.acceleration**2)))
    index = 0
    name = "the inertia"
    unit = si_unit("inertia", bench.axis)
    if abs(value[1]) > inertial:
        index = 1
        name = "the mean friction"
        unit = si_unit("effort", bench.axis)
    low = value[index] - half[index]
    high = value[index] + half[index]
    return f"{name} is {value[index]:.4g} {unit} in [{low:.4g}, {high:.4g}]" if high < 0.0 else None
