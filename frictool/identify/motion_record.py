"""Position and effort of one log on a uniform clock, the input of every method.

If a current drive has a lag (`loop_time_constant_s` > 0), the logged effort of a sample is the
value at the time of the sample. Without a lag, the drive holds this effort until the next sample.
The two cases differ by a shift of up to one sample period T between position and effort. This shift
would change the fitted inertia by T times the viscous friction. The record therefore states the
lag.

A drive changes its current at its samples (updates). If the lag of the drive is much shorter than
T, the time at which the current is read decides whether the log contains the effort before or after
the update. The reading is assumed to follow the update after an exponentially distributed time with
the mean READ_LATE T. This time exceeds the lag with the probability a = exp(-lag/(READ_LATE T));
the reading then counts as a reading after the update. The effort of the record is the mean of both
cases, weighted by their probabilities, and is therefore continuous in the lag.

A logged voltage is the command, which the drive holds until the next sample. If the bench states a
lag of a voltage drive, such as L/R of the winding, `lagged` computes the effort at the samples from
the voltage. Between two samples, this effort moves as the effort of a current drive does.

If the position sensor has a first-order lag (`encoder.time_constant_s`), `sensed` filters the
effort by the same lag, so that effort and reported position are delayed alike. The equation of
motion is linear during slip, so that both sides of the filtered equation have the same inertia and
viscous friction. The friction changes its sign before the reported motion does; `slip_mask` leaves
the affected samples out.

If a log has a measured velocity and no position, the position of its record is the trapezoidal
integral of the velocity from 0. Second differences of this position are differences of the
velocity, so that methods without terms over position need no change. The absolute position is
unknown, and velocity errors accumulate in the integral. Methods that depend on the position refuse
such a record (`methods`).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.adapters.servo_firmware import PendulumLoad, firmware_law, pendulum_load
from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.channels.bench_match import effort_is_measured
from frictool.logs.log import Log, Stream
from frictool.logs.quality.time_base import GAP, encoder_step
from frictool.plant.servo_firmware import ServoDrive
from frictool.typing import IntVector, Vector

JITTER = 0.1  # relative deviation from the period above which a sample interval is broken
SMALLEST_COUNT = 1e-9  # smallest quantisation step of a velocity, relative to its range
# share of broken intervals above which the record is resampled to a uniform clock
MOST_BROKEN = 0.02
# largest relative deviation of an interval from the median interval that is not erratic; a record
# is refused if more than half of its intervals are erratic
ERRATIC = 0.5
# mean time from the update of a current to its reading, in periods: 10 us of a period of 1 ms
READ_LATE = 0.01
READ_APART = 0.5  # longest time between reading effort and position of one row, in periods
ROUNDING = 1e-9  # resolution of a command computed from the effort, relative to the largest command
LONGEST_BRIDGE = 5.0  # periods; a longer interval of a jittering clock is a gap


P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True, eq=False)
class TemperatureSignal:
    """Temperature along a record, and the dependence of friction on the temperature.

    - values: temperature, (n,), degC
    - reference: temperature for which the sliding parameters are valid, degC
    - viscous_rate, coulomb_rate: approximate relative change of viscous and of Coulomb friction per
      kelvin, 1/K
    - viscous_curvature: coefficient of (temperature - reference)^2 in the exponent of viscous
      friction, 1/K^2; 0 if the logs do not determine this coefficient
    """

    values: Vector
    reference: float
    viscous_rate: float = 0.0
    coulomb_rate: float = 0.0
    viscous_curvature: float = 0.0

    @property
    def excess(self) -> Vector:
        """Return the temperature minus the reference temperature, (n,), K."""
        return self.values - self.reference


@dataclass(frozen=True, eq=False)
class WindingSignals:
    """Signals (n,) of a motor's winding, from the rows of a log in which all signals are finite.

    - time: s
    - voltage, current: V, A
    - position: rad | m
    """

    time: Vector
    voltage: Vector
    current: Vector
    position: Vector


@dataclass(frozen=True, eq=False)
class ServoSignals:
    """Inputs of a servo's firmware other than the goal, and the pendulum of the log.

    - drive: gain, supply voltage and torque switch, each (n,)
    - pendulum: known pendulum on the axis, or None
    """

    drive: ServoDrive
    pendulum: PendulumLoad | None


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """Uniformly sampled motion and effort of one log.

    - position: measured or integrated position, (n,), rad | m
    - effort: measured effort, (n,), N m | N
    - piece: for each sample, number of the gap-free part of the log that contains it, (n,), from 0
    - period: sample period, s
    - resolution: one encoder count, rad | m; for a measured velocity, one velocity count times the
      period
    - lag: time constant with which the effort moves from one sample to the next, s; 0 if the drive
      holds an effort until the next sample
    - reference: reference of the bench's controller, (n,), rad | m, or None
    - velocity: measured velocity, (n,), rad/s | m/s; None if the position was measured
    - temperature: temperature, and the dependence of friction on the temperature; None if the
      temperature was not measured
    - servo: inputs of a servo's firmware; None for another actuator
    - winding: signals of the motor's winding in the whole log; None if the log lacks one of them
    - sensor_lag: time constant of the position sensor's first-order lag, s; `effort` is filtered by
      this lag
    - load: part of `effort` that balances the known load, (n,), N m | N; None without a known load
    - effort_measured: True if a sensor measured the effort, behind the lag of a winding
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
    temperature: TemperatureSignal | None = None
    servo: ServoSignals | None = None
    winding: WindingSignals | None = None
    load: Vector | None = None
    sensor_lag: float = 0.0
    effort_measured: bool = False

    @property
    def effort_lag(self) -> float:
        """Return the time constant [s] with which `effort` moves between samples; 0 if held."""
        return self.lag + self.sensor_lag

    @property
    def measured(self) -> Vector:
        """Return the measured velocity (n,) if there is one, else the measured position (n,)."""
        return self.position if self.velocity is None else self.velocity

    @property
    def count(self) -> float:
        """Return the size of one count of `measured`, rad | m, or rad/s | m/s."""
        return self.resolution if self.velocity is None else self.resolution / self.period

    def part(self, kept: slice | IntVector) -> MotionRecord:
        """Return the record of the samples `kept`, with gap-free parts numbered from 0."""
        piece = self.piece[kept]
        signals: dict[str, Any] = {
            name: signal[kept]
            for name in ("time", "position", "effort", "reference", "velocity", "load")
            if (signal := getattr(self, name)) is not None
        }
        if self.temperature is not None:
            values = self.temperature.values[kept]
            signals["temperature"] = replace(self.temperature, values=values)
        if self.servo is not None:
            drive = ServoDrive(*(values[kept] for values in self.servo.drive))
            signals["servo"] = replace(self.servo, drive=drive)
        return replace(self, **signals, piece=piece - piece[0])

    def inside(self, inside: NDArray[np.bool_]) -> MotionRecord | None:
        """Return the record of the samples at which `inside` (n,) is True; None without samples.

        A new gap-free part begins wherever samples are left out.
        """
        kept = np.flatnonzero(inside)
        if kept.size == 0:
            return None
        part = self.part(kept)
        breaks = (np.diff(part.piece, prepend=0) > 0) | (np.diff(kept, prepend=kept[0]) > 1)
        return replace(part, piece=np.cumsum(breaks))


def once_per_record(
    function: Callable[Concatenate[MotionRecord, P], R],
) -> Callable[Concatenate[MotionRecord, P], R]:
    """Return `function` with a cache of its results for each record.

    A result is kept as long as the record exists.
    """
    kept: WeakKeyDictionary[MotionRecord, dict[tuple[object, ...], R]] = WeakKeyDictionary()

    @functools.wraps(function)
    def known(record: MotionRecord, /, *arguments: P.args, **named: P.kwargs) -> R:
        values = kept.setdefault(record, {})
        key = (*arguments, *named.items())
        if key not in values:
            values[key] = function(record, *arguments, **named)
        return values[key]

    return known


def make_record(
    name: str,
    time: Vector,
    position: Vector,
    effort: Vector,
    resolution: float,
    lag: float,
    reference: Vector | None = None,
) -> MotionRecord:
    """Return a record of signals (n,) in SI units, without samples that are not finite.

    Raises
    ------
    LogError
        If the time does not increase, if fewer than 3 samples are finite, or if more than half of
        the intervals differ from the median interval by more than ERRATIC times the median.

    Notes
    -----
    A record with jittering intervals is interpolated to a uniform grid of the median period. If few
    intervals jitter and no sample is missing, such as with rounded time stamps, the samples are
    taken as equidistant.
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
    if not np.all(steps > 0.0):
        raise LogError(
            name, f"the time does not increase after {time[int(np.argmin(steps > 0.0))]:g} s"
        )
    deviation = np.abs(steps - period)
    if np.mean(deviation > ERRATIC * period) > 0.5:
        raise LogError(
            name,
            "has no sample period: more than half of the intervals differ from the median, "
            f"{period:.3g} s, by more than {100 * ERRATIC:g} %; record it with a regular clock, "
            "or resample it (ingest --resample)",
        )
    broken = deviation > JITTER * period
    regular = _regular(time, period)
    if broken.any() and np.mean(broken) <= MOST_BROKEN and regular is not None:
        time, period = regular, float(regular[1] - regular[0])
        broken[:] = False
    piece = np.concatenate(([0], np.cumsum(broken))).astype(np.int64)
    record = MotionRecord(name, time, position, effort, piece, period, resolution, lag, reference)
    return _on_grid(record) if np.mean(broken) > MOST_BROKEN else record


def _regular(time: Vector, period: float) -> Vector | None:
    """Return equidistant times near `time`; None if a time differs by half a period or more."""
    if np.any(np.diff(time) > GAP * period):
        return None
    index = np.arange(time.size)
    slope, first = np.polyfit(index, time, 1)
    fitted = first + slope * index
    return fitted if np.all(np.abs(time - fitted) < 0.5 * period) else None


def _on_grid(record: MotionRecord) -> MotionRecord:
    """Return a record with jittering times on uniform grids, one grid for each gap-free part.

    A gap is an interval longer than LONGEST_BRIDGE periods. A gap-free part with fewer than 3 grid
    samples is left out. The position is interpolated by a monotone cubic (Fritsch and Carlson, SIAM
    J. Numer. Anal. 17, 1980), which does not overshoot between encoder counts. The effort of a
    drive with a lag is interpolated linearly. The effort of a drive without a lag is averaged over
    each grid period, so that its integral over time does not change.

    Raises
    ------
    LogError
        If no gap-free part is long enough.
    """
    edges = np.flatnonzero(np.diff(record.time) > LONGEST_BRIDGE * record.period) + 1
    parts: list[tuple[Vector, ...]] = []
    for kept in np.split(np.arange(record.time.size), edges):
        time = record.time[kept]
        count = int((time[-1] - time[0]) / record.period * (1.0 + 1e-12)) + 1
        if kept.size < 3 or count < 3:
            continue
        grid = np.minimum(time[0] + record.period * np.arange(count), time[-1])
        place = np.maximum(np.searchsorted(time, grid, side="right") - 1, 0)
        held = None if record.reference is None else record.reference[kept][place]
        parts.append(
            (
                grid,
                scipy.interpolate.PchipInterpolator(time, record.position[kept])(grid),
                _gridded_effort(time, record.effort[kept], grid, record.period, record.lag),
                np.full(count, len(parts), dtype=np.int64),
                held if held is not None else np.empty(0),
            )
        )
    if not parts:
        raise LogError(
            record.name,
            f"nowhere has 3 successive samples without a gap of more than {LONGEST_BRIDGE:g} "
            f"periods (period: {record.period:g} s); log without gaps",
        )
    joined = [np.concatenate(signals) for signals in zip(*parts, strict=True)]
    return replace(
        record,
        time=joined[0],
        position=joined[1],
        effort=joined[2],
        piece=joined[3],
        reference=None if record.reference is None else joined[4],
    )


def _gridded_effort(
    time: Vector, effort: Vector, grid: Vector, period: float, lag: float
) -> Vector:
    if lag > 0.0:
        return np.asarray(np.interp(grid, time, effort))
    ends = np.append(time, time[-1] + 2.0 * period)  # the last value is held past the grid
    impulse = np.concatenate(([0.0], np.cumsum(effort * np.diff(ends))))
    edges = np.interp(np.append(grid, grid[-1] + period), ends, impulse)
    return np.asarray(np.diff(edges) / period)


def velocity_record(
    name: str,
    time: Vector,
    velocity: Vector,
    effort: Vector,
    lag: float,
    reference: Vector | None = None,
) -> MotionRecord:
    """Return a record of signals (n,) in SI units, with a measured velocity and no position.

    Raises
    ------
    LogError
        For the reasons of `make_record`, or if the velocity does not change.
    """
    good = np.isfinite(time) & np.isfinite(velocity) & np.isfinite(effort)
    time, velocity, effort = time[good], velocity[good], effort[good]
    if velocity.size == 0 or np.ptp(velocity) == 0.0:
        raise LogError(name, "has no position, and its velocity does not change; log a motion")
    position = scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)
    count = velocity_count(velocity)
    record = make_record(
        name, time, position, effort, count, lag, None if reference is None else reference[good]
    )
    if record.time is not time and not np.array_equal(record.time, time):
        velocity = np.interp(record.time, time, velocity)
    return replace(record, velocity=velocity, resolution=count * record.period)


def velocity_count(velocity: Vector) -> float:
    """Return the quantisation step of a velocity signal (n,).

    If no step is visible, the noise of the velocity is computed from fourth differences. The result
    is then the step whose rounding error has the same rms as this noise.
    """
    step = encoder_step(np.unique(velocity))
    noise = float(np.sqrt(np.mean(np.diff(velocity, 4) ** 2) / 70.0)) if velocity.size > 4 else 0.0
    return max(step or np.sqrt(12.0) * noise, SMALLEST_COUNT * float(np.ptp(velocity)))


def record_of(log: Log, bench: Bench) -> MotionRecord:
    """Return the motion record of a log's main stream.

    The effort is the channel `effort`. If there is no such channel, the effort is the drive signal
    times the effort constant in bench.yaml. The effort of a servo is computed with the model of its
    firmware from goal and position. The temperature of any stream is interpolated to the times of
    the record.

    Raises
    ------
    LogError
        If position and velocity are both missing, or drive and effort are both missing. For a
        servo, if the goal, the position or the gain is missing.
    """
    record = lagged(_motion_of(log, bench), _command_lag(log, bench))
    measured = _effort_measured(log, bench)
    record = replace(record, winding=_winding(log), effort_measured=measured)
    if record.velocity is None:
        record = sensed(record, bench.encoder.lag_s)
    return _with_temperature(_with_servo(record, log, bench), log)


def late_reading(period: float, lag: float) -> float:
    """Return the probability that a current is read more than `lag` [s] after its update.

    period: sample period, s.
    """
    return math.exp(-lag / (READ_LATE * period))


def _winding(log: Log) -> WindingSignals | None:
    signals = log.main.signals
    names = ("voltage", "current", "position")
    if not signals.keys() >= set(names):
        return None
    rows = np.column_stack((log.main.time, *(signals[name] for name in names)))
    return WindingSignals(*rows[np.all(np.isfinite(rows), axis=1)].T)


def lagged(record: MotionRecord, lag: float) -> MotionRecord:
    """Return the record with its held effort filtered by a first-order lag `lag` [s].

    The drive is assumed to be in a steady state before the first sample of each gap-free part.
    """
    if lag == 0.0:
        return record
    pole = math.exp(-record.period / lag)
    starts = np.flatnonzero(np.diff(record.piece)) + 1
    parts = [
        scipy.signal.lfilter([0.0, 1.0 - pole], [1.0, -pole], held, zi=[held[0]])[0]
        for held in np.split(record.effort, starts)
    ]
    return replace(record, effort=np.concatenate(parts), lag=lag)


def sensed(record: MotionRecord, lag: float) -> MotionRecord:
    """Return the record with its effort also filtered by the lag `lag` [s] of the position sensor.

    Between two samples, the effort is constant, or moves exponentially with the time constant
    `effort_lag`. The filter is exact in both cases. The effort is assumed to be constant before the
    first sample of each gap-free part.
    """
    if lag == 0.0:
        return record
    period = record.period
    pole = math.exp(-period / lag)
    before, at = 1.0 - pole, 0.0  # weights of the effort one sample before and at the sample
    if record.effort_lag > 0.0:
        decay = math.exp(-period / record.effort_lag)
        rate = 1.0 / lag - 1.0 / record.effort_lag
        # mean of the drive's exponential over the sensor's exponential
        kept = (decay - pole) / (lag * rate) if abs(rate) * period > 1e-6 else pole * period / lag
        at = (1.0 - pole - kept) / (1.0 - decay)
        before = kept - at * decay
    parts = [
        scipy.signal.lfilter([at, before], [1.0, -pole], effort, zi=[(1.0 - at) * effort[0]])[0]
        for effort in np.split(record.effort, np.flatnonzero(np.diff(record.piece)) + 1)
    ]
    return replace(record, effort=np.concatenate(parts), sensor_lag=record.sensor_lag + lag)


def delayed(record: MotionRecord, delay: float) -> MotionRecord:
    """Return the record with its effort delayed by `delay` [s], interpolated linearly."""
    index = np.arange(record.effort.size, dtype=np.float64)
    late = np.interp(index - delay / record.period, index, record.effort)
    return replace(record, effort=late)


def fitted_sensor_lag(record: MotionRecord, bench: Bench) -> float:
    """Return the lag [s] of the position sensor that was fitted to logs; 0 if none was fitted."""
    return record.sensor_lag if bench.encoder.time_constant_s is None else 0.0


def without_lag(record: MotionRecord, bench: Bench) -> MotionRecord:
    """Return the record of a voltage drive with the effort before the lag, held between samples.

    This reverses `lagged`. The record does not determine the effort after the last sample of a
    gap-free part; it is taken as equal to the preceding effort. The record is returned unchanged if
    the drive is not a voltage drive, or if the record contains a lag of the position sensor.
    """
    if record.lag == 0.0 or record.sensor_lag > 0.0 or not bench.actuator.winding_delays:
        return record
    pole = math.exp(-record.period / record.lag)
    held = (record.effort[1:] - pole * record.effort[:-1]) / (1.0 - pole)
    last = np.flatnonzero(np.diff(record.piece))
    held[last] = held[np.maximum(last - 1, 0)]
    scale = ROUNDING * float(np.max(np.abs(held), initial=1e-300))
    return replace(record, effort=np.round(np.append(held, held[-1:]) / scale) * scale, lag=0.0)


def _command_lag(log: Log, bench: Bench) -> float:
    """Return the lag [s] from the logged voltage to the effort; 0 if the effort was measured."""
    actuator = bench.actuator
    if _effort_measured(log, bench) or not actuator.winding_delays:
        return 0.0
    return actuator.loop_time_constant_s


def _effort_measured(log: Log, bench: Bench) -> bool:
    return "effort" in log.main.signals and effort_is_measured(log, log.main, bench)


def _motion_of(log: Log, bench: Bench) -> MotionRecord:
    stream = log.main
    lag = bench.actuator.logged_lag_s
    effort = _effort(log, stream, bench)
    if lag > 0.0 and stream.time.size > 1:
        before = np.append(effort[:1], effort[:-1])
        late = late_reading(float(np.median(np.diff(stream.time))), lag)
        effort = effort + late * (before - effort)
    reference = stream.signals.get("reference")
    if "position" not in stream.signals and "velocity" in stream.signals:
        return velocity_record(
            log.source, stream.time, stream.signals["velocity"], effort, lag, reference
        )
    (position,) = log.require(stream, "position")
    return make_record(
        log.source, stream.time, position, effort, bench.encoder.resolution, lag, reference
    )


def _with_servo(record: MotionRecord, log: Log, bench: Bench) -> MotionRecord:
    if bench.actuator.servo is None:
        return record
    stream = log.main
    at = np.searchsorted(stream.time, record.time, side="right") - 1
    drive = ServoDrive(*(signal[at] for signal in _servo_drive(log, stream, bench)))
    known = {
        name: float(np.median(stream.signals[f"pendulum_{name}"]))
        for name in ("mass", "length")
        if f"pendulum_{name}" in stream.signals
    }
    return replace(record, servo=ServoSignals(drive, pendulum_load(bench.pendulum, **known)))


def _servo_drive(log: Log, stream: Stream, bench: Bench) -> ServoDrive:
    """Return the inputs (n,) of the firmware at the samples of a stream.

    If gain or supply were not logged, the values in bench.yaml are used. If the channel
    `torque_enabled` is missing, the torque is on.
    """
    servo = bench.actuator.servo
    assert servo is not None
    size = stream.time.size
    gain = stream.signals.get("gain")
    if gain is None and servo.gain is None:
        raise LogError(
            log.source,
            "has no channel `gain`, and actuator.servo of the bench states no gain; map the column "
            "in columns.gain, or write actuator.servo.gain",
        )
    return ServoDrive(
        np.full(size, servo.gain) if gain is None else gain,
        stream.signals.get("supply", np.full(size, bench.actuator.limit.value)),
        stream.signals.get("torque_enabled", np.ones(size)),
    )


def _with_temperature(record: MotionRecord, log: Log) -> MotionRecord:
    for stream in (log.main, *log.streams):
        measured = stream.signals.get("temperature")
        if measured is not None:
            values = np.interp(record.time, stream.time, measured)
            return replace(
                record, temperature=TemperatureSignal(values, reference_temperature([values]))
            )
    return record


def reference_temperature(measured: Sequence[Vector]) -> float:
    """Return the measured temperature nearest to the mean of all measured temperatures, degC.

    `measured` contains one vector (n,) for each record. The mean itself may lie between a cold and
    a hot log, where friction was not measured.
    """
    values = np.concatenate(measured)
    return float(values[np.argmin(np.abs(values - np.mean(values)))])


def _effort(log: Log, stream: Stream, bench: Bench) -> Vector:
    actuator = bench.actuator
    if "effort" in stream.signals:
        return stream.signals["effort"]
    if actuator.servo is not None:
        return _servo_effort(log, stream, bench)
    if actuator.drive not in stream.signals:
        for other in log.streams:
            for name in ("effort", actuator.drive):
                if name in other.signals:
                    raise LogError(
                        log.source,
                        f"has the {name} in {other.topic}, but the motion in {stream.topic}; join "
                        "the streams with frictool ingest --resample S",
                    )
    return log.require(stream, actuator.drive)[0] * actuator.constant.value


def _servo_effort(log: Log, stream: Stream, bench: Bench) -> Vector:
    if "reference" not in stream.signals:
        raise LogError(
            log.source,
            "has no channel `reference`, which is the goal of the servo; map the column of the "
            "goal position in columns.reference",
        )
    from frictool.engine.firmware_servo import profile_of  # compiled; other logs do not need it

    goal, position = log.require(stream, "reference", "position")
    law = firmware_law(bench)
    drive = _servo_drive(log, stream, bench)
    period = float(np.median(np.diff(stream.time)))
    profile = profile_of(goal, law, period)[:: law.steps(period)]
    volts = law.volts(profile, position, drive.gain, drive.supply)
    return np.asarray(law.constant * np.where(drive.enabled > 0.5, volts, 0.0))
