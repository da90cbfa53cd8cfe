"""Position and effort of one log on a uniform clock, the input of every method.

If the drive has a lag (`loop_time_constant_s` > 0), the logged effort is a continuous quantity
measured at the instant of its row. Without a lag, the effort of a row is held until the next row.
The record states which case applies, since half a sample of misalignment between the readings
causes an error of viscous T/2 in the inertia.

A log with a measured velocity and no position becomes a record too: its position is the trapezoidal
integral of the velocity, starting at 0. Second differences of this position are differences of the
velocity, so that methods without a term over the position work unchanged. The absolute position is
unknown, and velocity errors accumulate in it. Methods that depend on the position refuse such a
record (`methods`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.log import Log, Stream
from frictool.logs.quality.time_base import encoder_step
from frictool.typing import IntVector, Vector

JITTER = 0.1  # relative deviation of an interval from the period above which the record is split
SMALLEST_COUNT = 1e-9  # least count relative to the range of a velocity; finer ones are rounding
MOST_BROKEN = 0.2  # share of broken intervals above which the clock does not count as uniform


@dataclass(frozen=True)
class MotionRecord:
    """Uniformly sampled motion and effort of one log.

    - position: measured or integrated position, (n,), rad | m
    - effort: measured effort, (n,), N m | N
    - piece: number of the unbroken piece of each sample, from 0, (n,)
    - period: sample period, s
    - resolution: one encoder count, rad | m; for a measured velocity, one velocity count times the
      period
    - lag: time constant of the drive, s; 0 if the effort of a sample is held until the next
    - reference: reference of the bench's controller, (n,), rad | m, or None
    - velocity: measured velocity, (n,), rad/s | m/s; None if the position was measured
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
        """Return the measured motion signal (n,), the position or else the velocity."""
        return self.position if self.velocity is None else self.velocity

    @property
    def count(self) -> float:
        """Return one count of the measured motion signal, rad | m, or rad/s | m/s."""
        return self.resolution if self.velocity is None else self.resolution / self.period

    def part(self, kept: slice | IntVector) -> MotionRecord:
        """Return the record of the samples `kept`, with its pieces numbered from 0."""
        piece = self.piece[kept]
        signals: dict[str, Any] = {
            name: signal[kept]
            for name in ("time", "position", "effort", "reference", "velocity")
            if (signal := getattr(self, name)) is not None
        }
        return replace(self, **signals, piece=piece - piece[0])


def make_record(
    name: str,
    time: Vector,
    position: Vector,
    effort: Vector,
    resolution: float,
    lag: float,
    reference: Vector | None = None,
) -> MotionRecord:
    """Return a record of SI arrays (n,); samples that are not finite are dropped.

    Raises
    ------
    LogError
        If the clock is not uniform, or if fewer than 3 samples are finite.
    """
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
            f"{100 * np.mean(broken):.0f} % of the intervals are off the median period "
            f"{period:g} s; resample the log first",
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
    """Return a record of SI arrays (n,) with a measured velocity and no position.

    Raises
    ------
    LogError
        As `make_record`, and if the velocity does not change.
    """
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
    """Return the step of a quantised velocity (n,), or an equivalent step for its noise.

    The noise is estimated from fourth differences.
    """
    step = encoder_step(np.unique(velocity))
    noise = float(np.sqrt(np.mean(np.diff(velocity, 4) ** 2) / 70.0)) if velocity.size > 4 else 0.0
    return max(step or np.sqrt(12.0) * noise, SMALLEST_COUNT * float(np.ptp(velocity)))


def record_of(log: Log, bench: Bench) -> MotionRecord:
    """Return the record of a log's main stream.

    The effort is taken from the channel `effort`, else it is the drive signal times the constant.

    Raises
    ------
    LogError
        If both position and velocity are missing, or both drive and effort.
    """
    stream = log.main
    lag = bench.actuator.loop_time_constant_s
    effort = _effort(log, stream, bench)
    reference = stream.signals.get("reference")
    if "position" not in stream.signals and "velocity" in stream.signals:
        return velocity_record(
            log.source, stream.time, stream.signals["velocity"], effort, lag, reference
        )
    (position,) = log.require(stream, "position")
    return make_record(
        log.source, stream.time, position, effort, bench.encoder.resolution, lag, reference
    )


def _effort(log: Log, stream: Stream, bench: Bench) -> Vector:
    """Return the effort (n,) of a stream, N m | N."""
    actuator = bench.actuator
    if "effort" in stream.signals:
        return stream.signals["effort"]
    if actuator.drive not in stream.signals:
        for other in log.streams:
            for name in ("effort", actuator.drive):
                if name in other.signals:
                    raise LogError(
                        log.source,
                        f"has its {name} in {other.topic} and not in {stream.topic}; ingest with "
                        "--resample S",
                    )
    return log.require(stream, actuator.drive)[0] * actuator.constant.value
