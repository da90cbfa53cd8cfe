"""Check that position and drive have the same positive direction.

Inertia resists acceleration and friction takes energy out of the motion. In a log whose position or
drive is negated both come out negative. The check fits, to the samples certain to slip of one log,

    effort = inertia a + friction sign(v) + offset + declared loads

and looks at the larger of the two efforts, inertia rms(a) or friction: the log is reversed where
that one is negative beyond its uncertainty. The smaller one decides nothing, since a delay between
position and drive is enough to change its sign.

A log that gives no such fit, as one of breakaway ramps or of slow motion on a coarse encoder, is
judged stroke by stroke: the mean effort from the first to the last count of a stroke is friction
and offset. It is not judged by the work of the samples: a controller's derivative brakes at each
count, in the sample in which the count shows, so that the sum of effort times count is negative
while the mean is not.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.regression_samples import FEWEST_STROKES, parameters_of
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from frictool.identify.rows.strokes import find_strokes
from frictool.logs.quality.sign_check import CLEAR, net_work


def reversed_sign(
    records: Sequence[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> str | None:
    """Return what is wrong and how to mend it if position and drive of a record have opposite
    signs, else None."""
    for record in records:
        shown = _negative_effort(record, bench, settings)
        if shown is not None:
            return opposite_signs([record], shown, bench)
    return None


def negative_effort(records: Sequence[MotionRecord], bench: Bench, confidence: float) -> str | None:
    """Return what is wrong and how to mend it if the effort brakes the strokes of a record, else
    None.

    With strokes in both directions the mean effort along them has to be negative beyond its
    uncertainty, without the offset. With fewer, every stroke's mean effort and the net work have to
    be negative.
    """
    for record in records:
        direction, effort = stroke_efforts(record)
        friction = stroke_friction(direction, effort, confidence)
        work = net_work(record.position, record.effort)
        if friction is not None and friction.high < 0.0:
            shown = f"{friction.value:.4g} {si_unit('effort', bench.axis)} in [{friction.low:.4g}, {friction.high:.4g}]"
            return opposite_signs([record], f"the mean effort along its strokes is {shown}", bench)
        if (
            friction is None
            and direction.size
            and np.all(direction * effort < 0.0)
            and work is not None
            and work <= -CLEAR
        ):
            return opposite_signs(
                [record],
                f"the net work of the effort is {100.0 * work:.0f} % of its absolute work",
                bench,
            )
    return None


def stroke_efforts(record: MotionRecord) -> tuple[Vector, Vector]:
    """Return direction (s,) and mean effort (s,) of each stroke, from its first to its last
    count."""
    strokes = find_strokes(record)
    direction, effort = list[float](), list[float]()
    starts = np.flatnonzero(np.diff(strokes.number, prepend=-1))
    for first, end in itertools.pairwise([*starts.tolist(), record.position.size]):
        advance = strokes.advance[first:end]
        begin, last = int(np.argmax(advance > 0.0)), int(np.argmax(advance))
        if strokes.sign[first] != 0.0 and last > begin:
            direction.append(float(strokes.sign[first]))
            effort.append(float(np.mean(record.effort[first + begin : first + last])))
    return np.array(direction), np.array(effort)


def stroke_friction(direction: Vector, effort: Vector, confidence: float) -> Interval | None:
    """Return the mean effort along the strokes without the offset; None if there are too few
    strokes in one direction."""
    if min(np.count_nonzero(direction > 0.0), np.count_nonzero(direction < 0.0)) < FEWEST_STROKES:
        return None
    columns = np.column_stack((direction, np.ones(direction.size)))
    solution = solve(columns, effort, np.ones(direction.size), np.arange(direction.size))
    value, half = float(solution.value[0]), float(solution.half_width(confidence)[0])
    return Interval(value, value - half, value + half)


def opposite_signs(records: Sequence[MotionRecord], shown: str, bench: Bench) -> str:
    """Return the message: which logs, what shows it, what to change."""
    direction = bench.encoder.direction
    return (
        f"{', '.join(Path(record.name).name for record in records)}: position and drive have opposite signs: {shown}; set "
        f"encoder.direction: {-direction} in the bench (found: {direction}) and ingest the log again"
    )


def _negative_effort(
    record: MotionRecord, bench: Bench, settings: IdentificationSettings
) -> str | None:
    """Return the inertia or the mean friction of one record if it is negative and dominates the
    effort."""
    try:
        samples, window = slipping([record], bench, SMALLEST_SHARE, settings.window)
        if "coulomb" in parameters_of(samples)[1]:
            return None  # one direction, or too few strokes: an offset could be the friction
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
    value, half = solution.value, solution.half_width(settings.confidence)
    inertial = abs(value[0]) * float(np.sqrt(np.mean(samples.acceleration**2)))
    place, name, unit = (0, "the inertia", si_unit("inertia", bench.axis))
    if abs(value[1]) > inertial:
        place, name, unit = (1, "the mean friction", si_unit("effort", bench.axis))
    low, high = value[place] - half[place], value[place] + half[place]
    return f"{name} is {value[place]:.4g} {unit} in [{low:.4g}, {high:.4g}]" if high < 0.0 else None
