"""What every method starts from: the position and the effort of one log on a uniform clock.

Where the drive has a lag of its own (`loop_time_constant_s` > 0), the logged drive is a continuous
quantity measured at the instant of its row. Where it has none, the drive of a row is held until the
next one; half a sample of misalignment between the two readings is an error of viscous T/2 on the
inertia, so that the record says which it is.

A log with a measured velocity and no position is a record too: its position is the integral of the
velocity, by trapezoids, from 0 on. Second differences of it are differences of the velocity, so
that everything that looks at motion only works on it unchanged. Where the axis is, it does not
tell, and errors of the velocity add up in it: what looks at places refuses it (`methods`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.log import Log, Stream
from frictool.logs.quality.time_base import encoder_step

Vector = NDArray[np.float64]
JITTER = 0.1  # an interval that is off the period by more than this fraction breaks the record
SMALLEST_COUNT = 1e-9  # of a velocity's range: finer ones are rounding
MOST_BROKEN = (
    0.2  # with more broken intervals than this fraction there is no uniform clock to speak of
)


@dataclass(frozen=True)
class MotionRecord:
    """One log: `position` (n,) in rad | m, `effort` (n,) in N m | N, `piece` (n,) numbers the
    unbroken pieces from 0.

    period: s. resolution: rad | m of one encoder count. lag: s, of the drive; 0 where the effort of
    a sample is held until the next. reference (n,): what the bench's controller was asked for, rad
    | m, where the log holds it. velocity (n,): rad/s | m/s where it was measured and the position
    was not; a count is then what one of the velocity's adds to the position in a period.
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
    velocity: Vector | None = None

    @property
    def measured(self) -> Vector:
        """What was measured of the motion (n,), position or velocity."""
        return self.position if self.velocity is None else self.velocity

    @property
    def count(self) -> float:
        """One count of what was measured, rad | m, or rad/s | m/s."""
        return self.resolution if self.velocity is None else self.resolution / self.period

    def part(self, kept: slice) -> MotionRecord:
        """Return a part of the record, its pieces numbered from 0."""
        reference, velocity = (
            None if signal is None else signal[kept] for signal in (self.reference, self.velocity)
        )
        piece = self.piece[kept] - self.piece[kept][0]
        time, position, effort = (
            signal[kept] for signal in (self.time, self.position, self.effort)
        )
        return replace(
            self,
            time=time,
            position=position,
            effort=effort,
            piece=piece,
            reference=reference,
            velocity=velocity,
        )


def make_record(
    name: str,
    time: Vector,
    position: Vector,
    effort: Vector,
    resolution: float,
    lag: float,
    reference: Vector | None = None,
) -> MotionRecord:
    """A record of arrays (n,) in SI. Raises LogError where the clock is not uniform or nothing
    finite is left."""
    good = np.isfinite(time) & np.isfinite(position) & np.isfinite(effort)
    time, position, effort = time[good], position[good], effort[good]
    reference = None if reference is None else reference[good]
    if time.size < 3:
        raise LogError(
            name,
            f"has {time.size} samples with a finite position and effort; at least 3 are needed",
        )
    steps = np.diff(time)
    period = float(np.median(steps))
    broken = np.abs(steps - period) > JITTER * period
    if period <= 0.0 or np.mean(broken) > MOST_BROKEN:
        raise LogError(
            name,
            f"{100 * np.mean(broken):.0f} % of the intervals are off the median period {period:g} s; resample the log first",
        )
    piece = np.concatenate(([0], np.cumsum(broken))).astype(np.int64)
    return MotionRecord(name, time, position, effort, piece, period, resolution, lag, reference)


def velocity_record(
    name: str,
    time: Vector,
    velocity: Vector,
    effort: Vector,
    lag: float,
    reference: Vector | None = None,
) -> MotionRecord:
    """A record of arrays (n,) in SI without a position. Raises LogError as `make_record`, and where
    the velocity does not change."""
    good = np.isfinite(time) & np.isfinite(velocity) & np.isfinite(effort)
    time, velocity, effort = time[good], velocity[good], effort[good]
    if velocity.size == 0 or np.ptp(velocity) == 0.0:
        raise LogError(name, "has a velocity that does not change, and no position")
    position = cumulative_trapezoid(velocity, time, initial=0.0)
    count = velocity_count(velocity)
    record = make_record(
        name, time, position, effort, count, lag, None if reference is None else reference[good]
    )
    return replace(record, velocity=velocity, resolution=count * record.period)


def velocity_count(velocity: Vector) -> float:
    """The step of the lattice that a velocity (n,) lies on, or that whose noise its fourth
    differences show."""
    step = encoder_step(np.unique(velocity))
    noise = float(np.sqrt(np.mean(np.diff(velocity, 4) ** 2) / 70.0)) if velocity.size > 4 else 0.0
    return max(step or np.sqrt(12.0) * noise, SMALLEST_COUNT * float(np.ptp(velocity)))


def record_of(log: Log, bench: Bench) -> MotionRecord:
    """The record of a log's main stream, its effort from the channel `effort`, else drive times
    constant.

    Raises LogError where position and velocity, or both of drive and effort, are missing.
    """
    stream, lag = log.main, bench.actuator.loop_time_constant_s
    effort, reference = _effort(log, stream, bench), stream.signals.get("reference")
    if "position" not in stream.signals and "velocity" in stream.signals:
        return velocity_record(
            log.source, stream.time, stream.signals["velocity"], effort, lag, reference
        )
    (position,) = log.require(stream, "position")
    return make_record(
        log.source, stream.time, position, effort, bench.encoder.resolution, lag, reference
    )


def _effort(log: Log, stream: Stream, bench: Bench) -> Vector:
    """(n,) N m | N."""
    actuator = bench.actuator
    if "effort" in stream.signals:
        return stream.signals["effort"]
    if actuator.drive not in stream.signals:
        for other in log.streams:
            for name in ("effort", actuator.drive):
                if name in other.signals:
                    raise LogError(
                        log.source,
                        f"has its {name} in {other.topic} and not in {stream.topic}; ingest with --resample S",
                    )
    return log.require(stream, actuator.drive)[0] * actuator.constant.value
