"""Resistance, back-EMF constant and inductance of a motor whose voltage and current were logged.

    voltage = resistance i + constant v + inductance i' + offset

Let R be the resistance, K the constant, L the inductance, u0 the offset and T the sample period. If
the voltage u is held and the speed is constant during a period, the currents i at two successive
samples satisfy

    u = R i[k] + c (i[k+1] - i[k]) + K (x[k+1] - x[k])/T + u0,    c = R/(1 - e^(-R T/L))

The equation is summed with test functions (1 - s^2)^3 (`plant/weak_form.py`), which average the
noise. The equation does not contain friction, inertia or load.

In general, a log does not state the timing of the voltage. Between rows k and k + 1, the voltage
may be that of row k (held), that of row k - 1 (held and logged late), or the mean of both rows
(measured). All three timings are fitted. The result covers the interval of each timing whose sum of
squares is not clearly larger than the smallest sum.

The intervals come from a jackknife over parts of the logs. The noise of current and position biases
the parameters; the intervals include the largest bias.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, stroke_samples
from frictool.identify.rows.smoothing import (
    FOURTH_DIFFERENCE_GAIN,
    SHORTEST,
    choose_window,
    position_noise,
)
from frictool.logs.log import Log
from frictool.plant.weak_form import bell
from frictool.typing import Matrix, Vector

RESISTANCE, BACK_EMF, INDUCTANCE = "resistance", "back_emf_constant", "inductance"
COLUMNS = (RESISTANCE, BACK_EMF, INDUCTANCE)
PARTS = 30  # parts of the logs, each left out in turn
OVERLAP = 6  # windows per window length
CLEAR = 1.1  # ratio of two sums of squares above which the larger one is rejected
# weights of the voltages of rows k - 1, k and k + 1 in the voltage between rows k and k + 1
HELD, LATE, MEASURED = (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.5, 0.5)
LARGEST_ERROR = 0.3  # largest residual relative to the voltage's standard deviation
LONGEST_STEP = 1.5  # periods, longest interval of one piece


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


def winding_log(log: Log, record: MotionRecord) -> WindingLog | None:
    """Return voltage, current and position of a log, or None if one of these signals is missing.

    `record` is the motion record of the log.
    """
    signals = log.main.signals
    if not {"voltage", "current", "position"} <= signals.keys():
        return None
    columns = (log.main.time, signals["voltage"], signals["current"], signals["position"])
    rows = np.column_stack(columns)
    time, voltage, current, position = rows[np.all(np.isfinite(rows), axis=1)].T
    length = stroke_samples(record)
    window = choose_window(record, length, SMALLEST_SHARE) if length > 0.0 else SHORTEST
    piece = np.cumsum(np.diff(time, prepend=time[0]) > LONGEST_STEP * record.period)
    return WindingLog(
        voltage, current, position, piece, record.period, window, position_noise(record)
    )


def winding(
    logs: Sequence[WindingLog], bench: Bench, confidence: float
) -> dict[str, Interval | UnusableLogs]:
    """Return resistance [ohm], back-EMF constant [V s/rad | V s/m] and inductance [H].

    A value that is not determined is replaced by an UnusableLogs with the reason. If the voltage
    drives the axis without a lag, the voltage is taken as constant between samples. Otherwise, all
    timings of the module docstring are tried.
    """
    holds = bench.actuator.drive == "voltage" and bench.actuator.loop_time_constant_s == 0.0
    try:
        fits = [
            _fit(logs, timing, confidence)
            for timing in ((HELD,) if holds else (HELD, LATE, MEASURED))
        ]
    except UnusableLogs as error:
        return dict.fromkeys(COLUMNS, error)
    best = min(fits, key=lambda one: one.squares)
    alike = [one.intervals for one in fits if one.squares < CLEAR * best.squares]
    return {name: _judged([one.get(name) for one in alike]) for name in COLUMNS}


@dataclass(frozen=True)
class _WindingFit:
    intervals: dict[str, Interval]
    squares: float


def _fit(
    logs: Sequence[WindingLog], timing: tuple[float, float, float], confidence: float
) -> _WindingFit:
    """Return the fit for one assumed timing of the voltage, without undetermined parameters.

    Raises UnusableLogs if the equation does not explain the voltage.
    """
    parts = [part for log in logs for part in _rows(log, timing)]
    if not parts:
        raise UnusableLogs(
            "no gap-free part of a log is long enough to identify the winding; needed: at least "
            f"{min(log.window for log in logs) + OVERLAP} samples"
        )
    rows = np.concatenate([part for part, _ in parts])
    noise = np.sum([part.shape[0] * power for part, power in parts], axis=0)
    names = list(COLUMNS)
    if not np.any(rows[:, 1]):
        names.remove(BACK_EMF)  # a blocked motor
    used = [COLUMNS.index(name) for name in names]
    columns = np.column_stack((rows[:, used], np.ones(rows.shape[0])))
    target = rows[:, 3]
    value = np.linalg.lstsq(columns, target, rcond=None)[0]
    left = target - columns @ value
    error = float(np.std(left)) / float(np.std(target))
    if not error <= LARGEST_ERROR:
        raise UnusableLogs(
            f"resistance, back-EMF and inductance leave {100.0 * error:.3g} % of the voltage "
            f"unexplained (allowed: at most {100 * LARGEST_ERROR:g} %); check the signs of "
            "voltage, current and position"
        )
    change = names.index(INDUCTANCE)
    fast = not 0.0 < value[0] < value[change]  # the current settles within a period
    if fast:
        names.remove(INDUCTANCE)
    else:
        columns, target, noise = _linearised(columns, target, noise, value, change, logs[0].period)
    cluster = np.arange(target.size) * PARTS // target.size
    try:
        solution = solve(columns, target, np.ones(target.size), cluster)
    except SingularRegressors as fault:
        raise UnusableLogs(f"the logs do not separate the terms of the winding: {fault}") from None
    power = noise[np.ix_(used, used)]
    bias = np.abs(np.linalg.inv(columns.T @ columns)[:, :-1] @ power) @ np.abs(solution.value[:-1])
    half = solution.half_width(confidence) + bias
    intervals = {
        name: Interval.around(float(solution.value[k]), float(half[k]))
        for k, name in enumerate(COLUMNS[i] for i in used)
        if name in names
    }
    return _WindingFit(intervals, float(left @ left))


def _linearised(
    columns: Matrix, target: Vector, noise: Matrix, value: Vector, change: int, period: float
) -> tuple[Matrix, Vector, Matrix]:
    """Return columns (m, p), target (m,) and noise (3, 3), linearised in the inductance."""
    resistance, c = float(value[0]), float(value[change])
    exponent = -np.log1p(-resistance / c)  # R T/L
    inductance = resistance * period / exponent
    decay = np.exp(-exponent)
    by_inductance = c**2 * decay * period / inductance**2
    by_resistance = c / resistance - c**2 / resistance * decay * period / inductance
    mixing = np.eye(columns.shape[1])
    mixing[change, 0] = by_resistance
    mixing[change, change] = by_inductance
    known = c - by_resistance * resistance - by_inductance * inductance
    turned = np.eye(3)
    turned[2, 0] = by_resistance
    turned[2, 2] = by_inductance
    return columns @ mixing, target - known * columns[:, change], turned.T @ noise @ turned


def _rows(log: WindingLog, timing: tuple[float, float, float]) -> list[tuple[Matrix, Matrix]]:
    """Return the rows (m, 4) of each gap-free part, and the noise power (3, 3) of its columns.

    The columns belong to the resistance R, the back-EMF constant K, c (module docstring), and the
    voltage. The noise power is that of the first three columns.
    """
    phi = bell(log.window)
    step = np.convolve(phi, (1.0, -1.0))
    every = max(1, log.window // OVERLAP)
    current_noise = float(np.std(np.diff(log.current, 4))) / FOURTH_DIFFERENCE_GAIN
    late = np.append(phi, 0.0)
    power = np.zeros((3, 3))
    power[1, 1] = (log.noise / log.period) ** 2 * float(step @ step)
    for one, a in ((0, late), (2, step)):
        for other, b in ((0, late), (2, step)):
            power[one, other] = current_noise**2 * float(a @ b)
    out = []
    for number in np.unique(log.piece):
        kept = log.piece == number
        if np.count_nonzero(kept) < log.window + OVERLAP:
            continue
        voltage, current, position = log.voltage[kept], log.current[kept], log.position[kept]
        acting = timing[0] * voltage[:-2] + timing[1] * voltage[1:-1] + timing[2] * voltage[2:]
        columns = (
            np.convolve(current[1:-1], phi, mode="valid"),
            np.convolve(np.diff(position)[1:] / log.period, phi, mode="valid"),
            np.convolve(np.diff(current)[1:], phi, mode="valid"),
            np.convolve(acting, phi, mode="valid"),
        )
        out.append((np.column_stack(columns)[::every], power))
    return out


def _judged(intervals: Sequence[Interval | None]) -> Interval | UnusableLogs:
    """Return the hull of `intervals`, or an UnusableLogs if no positive value is determined."""
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
            f"the logs' interval [{low:.4g}, {high:.4g}] reaches zero; move faster, and load the "
            "motor more"
        )
    return Interval(known[0].value if len(known) == 1 else 0.5 * (low + high), low, high)
