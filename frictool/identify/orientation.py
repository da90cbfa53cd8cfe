"""Check that position and drive have the same positive direction.

Inertia resists acceleration and friction takes energy out of the motion. In a log whose position or drive is negated both come out
negative. The check fits, to the samples certain to slip of one log,

    effort = inertia a + friction sign(v) + offset + declared loads

and looks at the larger of the two efforts, inertia rms(a) or friction: the log is reversed where that one is negative beyond its
uncertainty. The smaller one decides nothing, since a delay between position and drive is enough to change its sign.

A log that gives no such fit, as one of breakaway ramps, is judged by the net work of its effort, which friction makes positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.methods import Settings
from frictool.identify.outcome import NothingUsable
from frictool.identify.record import Record
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import Singular, solve
from frictool.identify.rows.samples import parameters_of
from frictool.identify.rows.slipping import SMALLEST_SHARE, slipping
from frictool.logs.quality.sign import CLEAR, net_work


def reversed_sign(records: Sequence[Record], bench: Bench, settings: Settings) -> str | None:
    """Return what is wrong and how to mend it if position and drive of a record have opposite signs, else None."""
    for record in records:
        shown = _negative_effort(record, bench, settings)
        if shown is not None:
            return opposite_signs([record], shown, bench)
    return None


def negative_work(records: Sequence[Record], bench: Bench) -> str | None:
    """Return what is wrong and how to mend it if the effort of a record takes energy out of an axis that moves, else None."""
    for record in records:
        work = net_work(record.position, record.effort)
        if work is not None and work <= -CLEAR:
            return opposite_signs([record], f"the net work of the effort is {100.0 * work:.0f} % of its absolute work", bench)
    return None


def opposite_signs(records: Sequence[Record], shown: str, bench: Bench) -> str:
    """Return the message: which logs, what shows it, what to change."""
    direction = bench.encoder.direction
    return (
        f"{', '.join(Path(record.name).name for record in records)}: position and drive have opposite signs: {shown}; set "
        f"encoder.direction: {-direction} in the bench (found: {direction}) and ingest the log again"
    )


def _negative_effort(record: Record, bench: Bench, settings: Settings) -> str | None:
    """Return the inertia or the mean friction of one record if it is negative and dominates the effort."""
    try:
        samples, window = slipping([record], bench, SMALLEST_SHARE, settings.window)
        if "coulomb" in parameters_of(samples)[1]:
            return None  # one direction, or too few strokes: an offset could be the friction
    except NothingUsable:
        return None
    columns = np.column_stack((samples.acceleration, samples.sign, np.ones(samples.sign.size), *samples.loads.values()))
    cluster = clusters(samples.stroke, samples.sign, samples.counts, 3 * window)
    try:
        solution = solve(columns, samples.effort, np.ones(samples.sign.size), cluster)
    except Singular:
        return None
    value, half = solution.value, solution.half_width(settings.confidence)
    inertial = abs(value[0]) * float(np.sqrt(np.mean(samples.acceleration**2)))
    place, name, unit = (0, "the inertia", si_unit("inertia", bench.axis))
    if abs(value[1]) > inertial:
        place, name, unit = (1, "the mean friction", si_unit("effort", bench.axis))
    low, high = value[place] - half[place], value[place] + half[place]
    return f"{name} is {value[place]:.4g} {unit} in [{low:.4g}, {high:.4g}]" if high < 0.0 else None
