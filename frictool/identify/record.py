"""What every method starts from: the position and the effort of one log on a uniform clock.

Where the drive has a lag of its own (`loop_time_constant_s` > 0), the logged drive is a continuous quantity measured at the instant
of its row. Where it has none, the drive of a row is held until the next one; half a sample of misalignment between the two
readings is an error of viscous T/2 on the inertia, so that the record says which it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.log import Log

Vector = NDArray[np.float64]
JITTER = 0.1  # an interval that is off the period by more than this fraction breaks the record
MOST_BROKEN = 0.2  # with more broken intervals than this fraction there is no uniform clock to speak of


@dataclass(frozen=True)
class Record:
    """One log: `position` (n,) in rad | m, `effort` (n,) in N m | N, `piece` (n,) numbers the unbroken pieces from 0.

    period: s. resolution: rad | m of one encoder count. lag: s, of the drive; 0 where the effort of a sample is held until the next.
    reference (n,): what the bench's controller was asked for, rad | m, where the log holds it.
    """

    name: str
    time: Vector
    position: Vector
    effort: Vector
    piece: NDArray[np.int64]
    period: float
    resolution: float
    lag: float
    reference: Vector | None = None


def make_record(
    name: str, time: Vector, position: Vector, effort: Vector, resolution: float, lag: float, reference: Vector | None = None
) -> Record:
    """A record of arrays (n,) in SI. Raises LogError where the clock is not uniform or nothing finite is left."""
    good = np.isfinite(time) & np.isfinite(position) & np.isfinite(effort)
    time, position, effort = time[good], position[good], effort[good]
    reference = None if reference is None else reference[good]
    if time.size < 3:
        raise LogError(name, f"has {time.size} samples with a finite position and effort; at least 3 are needed")
    steps = np.diff(time)
    period = float(np.median(steps))
    broken = np.abs(steps - period) > JITTER * period
    if period <= 0.0 or np.mean(broken) > MOST_BROKEN:
        raise LogError(
            name, f"{100 * np.mean(broken):.0f} % of the intervals are off the median period {period:g} s; resample the log first"
        )
    piece = np.concatenate(([0], np.cumsum(broken))).astype(np.int64)
    return Record(name, time, position, effort, piece, period, resolution, lag, reference)


def record_of(log: Log, bench: Bench) -> Record:
    """The record of a log's main stream, its effort from the channel `effort`, else drive times constant.

    Raises LogError where the position or both of drive and effort are missing.
    """
    stream, actuator = log.main, bench.actuator
    (position,) = log.require(stream, "position")
    measured = "effort" in stream.signals
    effort = stream.signals["effort"] if measured else log.require(stream, actuator.drive)[0] * actuator.constant.value
    reference = stream.signals.get("reference")
    return make_record(log.source, stream.time, position, effort, bench.encoder.resolution, actuator.loop_time_constant_s, reference)
