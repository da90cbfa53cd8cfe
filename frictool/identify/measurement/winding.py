"""Resistance, back-EMF constant and inductance of a motor whose voltage and current were logged.

    voltage(t - delay) = resistance (i - offset) + constant v + inductance i'

A driver of bipolar transistors and the brushes of the motor take a voltage that does not grow with
the current. In the equation, the voltage is then sign(u) max(|u| - drop, 0), where u is the logged
voltage. The drop is fitted if its interval is above zero. Without the drop, the resistance would be
too large.

Let R be the resistance, K the constant, L the inductance, T the sample period and e = exp(-R T/L).
The voltage of a row is constant until the next row. The currents i at two successive samples
satisfy

    i[k+1] = e i[k] + (1 - e) (u[k] - K v[k])/R

u[k] and v[k] are the means of voltage and speed over the period, weighted by exp(-R s/L) at the
time s before the end of the period. v[k] follows from the mean speed (x[k+1] - x[k])/T and the
slope of the speed. The slope is a difference of successive mean speeds. Without the slope, the
resistance would be wrong by up to K^2 T/(2 J), where J is the inertia.

The delay is the time from a row of the log until its voltage acts. If instead the current of the
row is read late, the delay is negative, and its absolute value is the time from the row to this
reading. A log does not state the delay, so that it is fitted, too. The current is simulated from
voltage and position (output error): the noise of the current then biases no parameter. Simulated
and measured current are averaged by the test function (1 - s^2)^3 (`plant/weak_form.py`), which
reduces the noise of the position. The equation does not contain friction, inertia or load.

The intervals of the results come from a jackknife over parts of the logs. They include the bias due
to noise of the position. They also include the results with each of three differences for the
slope: central, forward and backward.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import JITTER, MotionRecord, once_per_record
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, stroke_samples
from frictool.identify.rows.smoothing import SHORTEST, choose_window, position_noise
from frictool.plant.weak_form import sampled_test_function
from frictool.typing import Matrix, Vector

RESISTANCE, BACK_EMF, INDUCTANCE = "resistance", "back_emf_constant", "inductance"
COLUMNS = (RESISTANCE, BACK_EMF, INDUCTANCE)
VOLTAGE_DROP = "voltage_drop"
NAMES = {**dict(enumerate(COLUMNS)), 5: VOLTAGE_DROP}  # by column of the derivatives
PARTS = 30  # number of parts of the logs, each left out in turn
OVERLAP = 6  # windows per window length
LONGEST = 200_000  # largest number of samples of a log that are used
EARLIEST, LATEST = -1.0, 4.0  # bounds of the delay, in sample periods
FASTEST, SLOWEST = 0.02, 50.0  # bounds of the electrical time constant, in sample periods
GRID = 12, 11  # numbers of time constants and of delays among which the start is searched
STEP = 1e-3  # step of derivatives: relative for the time constant, in sample periods for the delay
# smallest lower bound of the time constant, in periods, with which the inductance is identified; a
# row's time is known within JITTER periods
SETTLED = JITTER
LARGEST_ERROR = 0.3  # largest residual relative to the voltage's standard deviation
LONGEST_STEP = 1.5  # periods, longest time between two samples of a piece
# the slope of the speed in a period is a weighted sum of two changes of the mean speed: from the
# previous period, and to the next period
CENTRAL, FORWARD, BACKWARD = (0.5, 0.5), (0.0, 1.0), (1.0, 0.0)


@dataclass(frozen=True)
class WindingLog:
    """Voltage [V], current [A] and position [rad | m] of one log, each (n,).

    - piece: number of the gap-free part of the log that contains the sample, (n,)
    - period: sample period, s
    - window: length of the test function, samples
    - noise: rms noise of the position, rad | m
    """

    voltage: Vector
    current: Vector
    position: Vector
    piece: Vector
    period: float
    window: int
    noise: float


def winding_log(record: MotionRecord) -> WindingLog | None:
    """Return voltage, current and position of a log, or None if one of these signals is missing."""
    signals = record.winding
    if signals is None:
        return None
    length = stroke_samples(record)
    return WindingLog(
        signals.voltage[:LONGEST],
        signals.current[:LONGEST],
        signals.position[:LONGEST],
        np.cumsum(
            np.diff(signals.time[:LONGEST], prepend=signals.time[0]) > LONGEST_STEP * record.period
        ),
        record.period,
        choose_window(record, length, SMALLEST_SHARE) if length > 0.0 else SHORTEST,
        position_noise(record),
    )


def winding_of_records(
    records: Sequence[MotionRecord], confidence: float
) -> dict[str, Interval | UnusableLogs]:
    """Return the result of `winding` for the logs with voltage, current and position.

    The result is empty if no log contains these signals.
    """
    logged = [record for record in records if record.winding is not None]
    return _winding_of(logged[0], tuple(logged[1:]), confidence) if logged else {}


@once_per_record
def _winding_of(
    record: MotionRecord, others: tuple[MotionRecord, ...], confidence: float
) -> dict[str, Interval | UnusableLogs]:
    logs = [log for one in (record, *others) if (log := winding_log(one)) is not None]
    return winding(logs, confidence)


def winding(logs: Sequence[WindingLog], confidence: float) -> dict[str, Interval | UnusableLogs]:
    """Return resistance [ohm], back-EMF constant [V s/rad | V s/m] and inductance [H].

    If the logs do not determine a value, the result contains an UnusableLogs with the reason
    instead. If the logs show a voltage drop [V], the result contains its interval, too.
    """
    try:
        fits = _fits(logs, confidence)
    except UnusableLogs as error:
        return dict.fromkeys(COLUMNS, error)
    out = {name: _judged([one.get(name) for one in fits]) for name in COLUMNS}
    inductance, resistance = out[INDUCTANCE], out[RESISTANCE]
    shortest = SETTLED * logs[0].period
    if (
        isinstance(inductance, Interval)
        and isinstance(resistance, Interval)
        and inductance.low < shortest * resistance.high
    ):
        out[INDUCTANCE] = _judged([None])
    drop = _judged([one.get(VOLTAGE_DROP) for one in fits])
    return {**out, VOLTAGE_DROP: drop} if isinstance(drop, Interval) else out


class _NonlinearParameters(NamedTuple):
    """Electrical time constant [s], delay of the voltage [s] and voltage drop [V]."""

    lag: float
    delay: float
    drop: float = 0.0


@dataclass(frozen=True)
class _Piece:
    """Gap-free part of a log: voltage and current (n,), mean speed (n - 1,) between samples."""

    voltage: Vector
    current: Vector
    speed: Vector
    log: WindingLog

    def smoothed(self, signal: Vector) -> Vector:
        """Return the averages of a signal (n,) over test functions, without the piece's ends."""
        inner = signal[int(LATEST) + 1 : -2]
        every = max(1, self.log.window // OVERLAP)
        return np.asarray(
            np.convolve(inner, sampled_test_function(self.log.window), mode="valid")[::every]
        )

    def voltage_response(self, nonlinear: _NonlinearParameters) -> Vector:
        """Return the current (n,) that the voltage causes, times the resistance."""
        lag, delay, drop = nonlinear
        voltage = np.sign(self.voltage) * np.maximum(np.abs(self.voltage) - drop, 0.0)
        period = self.log.period
        whole = int(np.floor(delay / period))
        share = delay / period - whole
        ahead = np.arange(self.speed.size) - whole
        new, old = (voltage[np.clip(ahead - k, 0, voltage.size - 1)] for k in (0, 1))
        decay = np.exp(-period / lag)
        before = (np.exp(-(1.0 - share) * period / lag) - decay) / (1.0 - decay)
        return _lagged(new + before * (old - new), decay)

    def speed_response(self, lag: float, slope: tuple[float, float]) -> Vector:
        """Return the speed (n,), filtered by a lag [s].

        The slope of the speed within a sample period is a weighted sum of the backward and the
        forward difference quotient. `slope` contains the two weights.
        """
        return _lagged(_weighted_speed(self.speed, self.log.period, lag, slope), _decay(self, lag))

    def initial_response(self, lag: float) -> Vector:
        """Return the decaying part of the current (n,) that is due to the current's first value."""
        return np.asarray(self.current[0] * _decay(self, lag) ** np.arange(self.current.size))


def _decay(piece: _Piece, lag: float) -> float:
    return float(np.exp(-piece.log.period / lag))


def _lagged(mean: Vector, decay: float) -> Vector:
    """Return the response (n + 1,) of a first-order lag to the mean input (n,) of each period."""
    return np.concatenate(([0.0], scipy.signal.lfilter([1.0 - decay], [1.0, -decay], mean)))


def _weighted_speed(speed: Vector, period: float, lag: float, slope: tuple[float, float]) -> Vector:
    change = np.diff(speed) / period
    rising = slope[0] * np.append(change[:1], change) + slope[1] * np.append(change, change[-1:])
    later = period / -np.expm1(-period / lag) - lag - 0.5 * period
    return np.asarray(speed + later * rising)


def _pieces(logs: Sequence[WindingLog]) -> list[_Piece]:
    out = []
    for log in logs:
        for number in np.unique(log.piece):
            kept = log.piece == number
            if np.count_nonzero(kept) >= log.window + 2 * OVERLAP + int(LATEST):
                speed = np.diff(log.position[kept]) / log.period
                out.append(_Piece(log.voltage[kept], log.current[kept], speed, log))
    return out


@dataclass(frozen=True)
class _CurrentModel:
    """Model of the averaged current of all pieces.

    - slope: weights of the backward and the forward difference in the speed's slope, such as
      CENTRAL
    - moving: False for a blocked motor, which has no back-EMF
    - drops: True if a voltage drop is fitted
    """

    pieces: Sequence[_Piece]
    slope: tuple[float, float]
    moving: bool
    drops: bool = False

    @property
    def period(self) -> float:
        """Return the sample period [s]."""
        return self.pieces[0].log.period

    @property
    def largest(self) -> float:
        """Return the largest magnitude of the voltage [V]."""
        return max(float(np.max(np.abs(piece.voltage))) for piece in self.pieces)

    def voltages(self, nonlinear: _NonlinearParameters) -> Vector:
        """Return the averaged current (m,) that the voltages cause, times the resistance."""
        return _joined(self.pieces, [p.voltage_response(nonlinear) for p in self.pieces])

    def speeds(self, lag: float) -> Vector:
        """Return the speed (m,), averaged and filtered by the lag."""
        return _joined(self.pieces, [p.speed_response(lag, self.slope) for p in self.pieces])

    def linear(self, nonlinear: _NonlinearParameters) -> tuple[Vector, Vector]:
        """Return fitted 1/R, -K/R and current offset (module docstring), and the residual (m,)."""
        lag = nonlinear.lag
        speeds = self.speeds(lag) if self.moving else np.zeros(1)
        voltages = self.voltages(nonlinear)
        columns = np.column_stack(
            (voltages, np.broadcast_to(speeds, voltages.shape), np.ones(voltages.size))
        )
        left = [p.current - p.initial_response(lag) for p in self.pieces]
        target = _joined(self.pieces, left)
        value = np.asarray(np.linalg.lstsq(columns, target, rcond=None)[0], dtype=np.float64)
        return value, target - columns @ value

    def best(self, start: _NonlinearParameters | None) -> _NonlinearParameters:
        """Return the time constant, delay and drop that minimise the squared residual."""
        period, largest = self.period, self.largest

        def nonlinear(z: Vector) -> _NonlinearParameters:
            drop = float(z[2]) * largest if self.drops else 0.0
            return _NonlinearParameters(float(np.exp(z[0])) * period, float(z[1]) * period, drop)

        def left(z: Vector) -> Vector:
            return self.linear(nonlinear(z))[1]

        if start is None:
            lags = np.linspace(np.log(FASTEST), np.log(SLOWEST), GRID[0] + 2)[1:-1]
            delays = np.linspace(EARLIEST, LATEST, GRID[1])
            tried = [np.array([lag, delay, 0.0]) for lag in lags for delay in delays]
            first = min(tried, key=lambda z: float(np.sum(left(z) ** 2)))
        else:
            first = np.array(
                [np.log(start.lag / period), start.delay / period, start.drop / max(largest, STEP)]
            )
        used = 3 if self.drops else 2
        low = np.array([np.log(FASTEST), EARLIEST, 0.0])[:used]
        high = np.array([np.log(SLOWEST), LATEST, 1.0])[:used]
        first = np.clip(first[:used], low + STEP, high - STEP)
        z = scipy.optimize.least_squares(left, first, bounds=(low, high), diff_step=STEP).x
        return nonlinear(z)

    def derivatives(self, value: Vector, nonlinear: _NonlinearParameters) -> Matrix:
        """Return the derivatives (m, 6) of the current with respect to the winding's parameters.

        The parameters are resistance, back-EMF constant, inductance, delay, offset and voltage
        drop.
        """
        lag, delay, drop = nonlinear
        resistance = 1.0 / value[0]
        constant = -value[1] * resistance
        speeds = self.speeds(lag)
        net = self.voltages(nonlinear) - constant * speeds
        higher, lower = lag * (1.0 + STEP), lag * (1.0 - STEP)
        by_lag = self.voltages(_NonlinearParameters(higher, delay, drop))
        by_lag -= self.voltages(_NonlinearParameters(lower, delay, drop))
        by_lag -= constant * (self.speeds(higher) - self.speeds(lower))
        by_lag *= value[0] / (higher - lower)
        step = STEP * self.period
        by_delay = self.voltages(_NonlinearParameters(lag, delay + step, drop))
        by_delay -= self.voltages(_NonlinearParameters(lag, delay - step, drop))
        volts = STEP * self.largest
        by_drop = self.voltages(_NonlinearParameters(lag, delay, drop + volts))
        by_drop -= self.voltages(_NonlinearParameters(lag, delay, drop - volts))
        return np.column_stack(
            (
                -net * value[0] ** 2 - by_lag * lag * value[0],
                -speeds * value[0],
                by_lag * value[0],
                by_delay * value[0] / (2.0 * step),
                np.ones(net.size),
                by_drop * value[0] / (2.0 * volts) if volts > 0.0 else np.zeros(net.size),
            )
        )


def _joined(pieces: Sequence[_Piece], signals: Sequence[Vector]) -> Vector:
    return np.concatenate([p.smoothed(one) for p, one in zip(pieces, signals, strict=True)])


def _fits(logs: Sequence[WindingLog], confidence: float) -> list[dict[str, Interval]]:
    """Return the intervals of the determined parameters, for each formula of the speed's slope.

    Raises UnusableLogs if no gap-free part is long enough, or if the equation does not explain the
    current.
    """
    pieces = _pieces(logs)
    if not pieces:
        raise UnusableLogs(
            "no gap-free part of a log is long enough to identify the winding; needed: at least "
            f"{min(log.window for log in logs) + 2 * OVERLAP + int(LATEST)} samples"
        )
    moving = any(np.any(piece.speed) for piece in pieces)
    model = _CurrentModel(pieces, CENTRAL, moving)
    nonlinear = model.best(None)
    dropping = replace(model, drops=True)
    with_drop = dropping.best(nonlinear)
    if _has_drop(dropping, with_drop, confidence):
        model, nonlinear = dropping, with_drop
    out = [_intervals(model, nonlinear, confidence)]
    for slope in (FORWARD, BACKWARD) if moving else ():
        other = replace(model, slope=slope)
        nonlinear = other.best(nonlinear)
        out.append(_intervals(other, nonlinear, confidence))
    return out


def _has_drop(model: _CurrentModel, nonlinear: _NonlinearParameters, confidence: float) -> bool:
    """Return whether the interval of the fitted voltage drop is above zero."""
    try:
        found = _intervals(model, nonlinear, confidence).get(VOLTAGE_DROP)
    except UnusableLogs:
        return False
    return found is not None and found.low > 0.0


def _intervals(
    model: _CurrentModel, nonlinear: _NonlinearParameters, confidence: float
) -> dict[str, Interval]:
    """Return the intervals of the determined parameters, linearised at the estimate `nonlinear`."""
    lag, delay, drop = nonlinear
    value, left = model.linear(nonlinear)
    size = value[0] * float(np.std(model.voltages(nonlinear)))
    error = float(np.std(left)) / size if size > 0.0 else np.inf
    if not error <= LARGEST_ERROR:
        raise UnusableLogs(
            f"resistance, back-EMF and inductance leave {100.0 * error:.3g} % of the voltage "
            f"unexplained (allowed: at most {100 * LARGEST_ERROR:g} %); check the signs of "
            "voltage, current and position"
        )
    derivatives = model.derivatives(value, nonlinear)
    resistance = 1.0 / value[0]
    estimate = np.array(
        [resistance, -value[1] * resistance, lag * resistance, delay, value[2], drop]
    )
    named = [0, 1, 2] if model.moving else [0, 2]
    others = [4, 5] if model.drops else [4]
    cluster = np.arange(left.size) * PARTS // left.size
    for used in ([*named, 3, *others], [k for k in named if k != 2] + others):
        columns = derivatives[:, used]
        try:
            target = left + columns @ estimate[used]
            half = solve(columns, target, np.ones(left.size), cluster).half_width(confidence)
        except SingularRegressors as fault:
            reason = fault
            continue
        half += np.abs(_bias(model, estimate, columns, used, lag))
        return {
            NAMES[k]: Interval.around(float(estimate[k]), float(reach))
            for k, reach in zip(used, half, strict=True)
            if k in NAMES
        }
    raise UnusableLogs(f"the logs do not separate the terms of the winding: {reason}")


def _bias(
    model: _CurrentModel, estimate: Vector, columns: Matrix, used: Sequence[int], lag: float
) -> Vector:
    """Return the bias (p,) of the parameters `used` due to the noise of the position."""
    resistance, constant = float(estimate[0]), float(estimate[1])
    shared = np.zeros(6)
    for piece in model.pieces:
        log = piece.log
        impulse = np.zeros(3 * log.window + int(10.0 * lag / log.period))
        impulse[log.window] = 1.0
        speed = _weighted_speed(np.diff(impulse) / log.period, log.period, lag, model.slope)
        response = np.convolve(
            _lagged(speed, _decay(piece, lag)), sampled_test_function(log.window)
        )
        power = log.noise**2 * float(response @ response) * piece.smoothed(piece.current).size
        shared[:2] += power * constant / resistance**2 * np.array([constant / resistance, -1.0])
    return np.asarray(np.linalg.solve(columns.T @ columns, shared[list(used)]))


def _judged(intervals: Sequence[Interval | None]) -> Interval | UnusableLogs:
    """Return the smallest interval that contains all `intervals`.

    If they do not determine a positive value, return an UnusableLogs instead.

    The result has the value of the first interval.
    """
    known = [one for one in intervals if one is not None]
    if len(known) < len(intervals):
        return UnusableLogs(
            "the logs do not determine this value: the motor did not move, or the current settles "
            "within a sample period"
        )
    low = min(one.low for one in known)
    high = max(one.high for one in known)
    if low <= 0.0:
        return UnusableLogs(
            f"the logs' interval [{low:.4g}, {high:.4g}] reaches zero; use higher speeds and "
            "currents"
        )
    return Interval(known[0].value, low, high)
