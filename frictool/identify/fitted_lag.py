"""First-order lag of the measured position, such as that of a 4-20 mA transmitter, fitted to logs.

A regression contains a delay or lag only to first order. For a lag tau and motions of the angular
frequency w, the error of this approximation grows with w tau: a part of tau times the viscous
friction then remains in the inertia. In this module, the effort is filtered by the lag itself, and
the regression fits only the remaining lag to first order. A secant iteration makes the remaining
lag vanish. A pure delay, such as that of wrong time stamps, is fitted in the same way.

From effort to reported position, the axis has the transfer function

    1/(viscous s (T s + 1)(tau s + 1))        T = inertia/viscous

T and tau can be exchanged. Only the instants at which the friction changes its sign distinguish the
two. The inertia may therefore be tau times the viscous friction instead (`exchanged_inertia`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import Estimate
from frictool.identify.effect_regression import EffectRegression, effect_regression
from frictool.identify.estimators.explanation_search import NOTICEABLE
from frictool.identify.estimators.searched_records import SearchedRecords
from frictool.identify.fit_result import Interval, SlidingFit
from frictool.identify.interval_checks import contradicts
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import READ_APART, MotionRecord, delayed, sensed
from frictool.identify.rows.effects import DELAY
from frictool.identify.rows.smoothing import smoothed, white_noise

STEPS = 8  # largest number of iterations
# largest remaining lag that ends the iteration: relative to the lag, or to the half width of the
# interval of the remaining lag
CONVERGED, CERTAIN = (0.01, 0.2)
SLOPES = (0.05, 2.0)  # limits of the assumed change of the remaining lag per change of the lag

# function that delays or filters the effort of a record by a time [s]
Move = Callable[[MotionRecord, float], MotionRecord]


@dataclass(frozen=True)
class LateFit:
    """Regression of records whose effort was delayed or filtered.

    - time: delay or time constant, s
    - rest: remaining delay that the regression fits, negative if `time` is too short, s
    - square: mean square of the residual, (N m)^2 | N^2
    """

    regression: EffectRegression
    time: float
    rest: Interval
    square: float

    @property
    def interval(self) -> Interval:
        """Return the delay or time constant with its interval, s."""
        return Interval.around(self.time - self.rest.value, self.rest.half_width)


def late_fit(
    fit: SlidingFit,
    records: Sequence[MotionRecord],
    bench: Bench,
    model: EffectRegression,
    move: Move,
) -> LateFit | None:
    """Return the regression with the hypotheses of `model` and an exact delay or lag.

    The iteration starts with the delay of `model`. Return None if `model` has no delay, if the
    rows do not determine the delay, or if a lag becomes negative.
    """
    late = model.intervals().get(DELAY)
    time = 0.0 if late is None else -late.value
    before: tuple[float, float] | None = None
    found = None
    for _ in range(STEPS):
        changed = [move(one, time) for one in records]
        regression = effect_regression(fit, changed, bench, model.confidence)
        if late is None or regression is None:
            return None
        regression = replace(regression, used=model.used)
        rest = regression.intervals().get(DELAY)
        if rest is None or not math.isfinite(rest.half_width):
            return None
        square = float(np.mean(regression.rows.residual(regression.used) ** 2))
        found = LateFit(regression, time, rest, square)
        if abs(rest.value) <= max(CONVERGED * abs(time), CERTAIN * rest.half_width):
            break
        slope = 1.0
        if before is not None and time != before[0]:
            slope = float(np.clip((rest.value - before[1]) / (time - before[0]), *SLOPES))
        before = (time, rest.value)
        time -= rest.value / slope
        if move is sensed and time <= 0.0:
            return None
    return found


def fitted_lag(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> Interval | None:
    """Return the time constant [s] of an undeclared lag of the logged position, or None.

    The result is None in five cases:

    - The lag need not be fitted (`lag_is_known`).
    - `fit` contains no delay by which the position follows the effort.
    - The lag may be shorter than the time between the readings of effort and position in a row.
    - The iteration for the lag does not converge.
    - A pure delay explains the effort nearly as well as the lag.

    The time constant inertia/viscous of the fit with the lag is returned in place of the lag if the
    fitted inertia contradicts bench.yaml and the exchanged inertia (`exchanged_inertia`) does not.
    """
    if lag_is_known(records, bench) or late_position(fit, records) is None:
        return None
    model = effect_regression(fit, records, bench, confidence)
    lag = None if model is None else late_fit(fit, records, bench, model, sensed)
    if model is None or lag is None or abs(lag.rest.value) > lag.rest.half_width:
        return None

    def late_effort(record: MotionRecord, time: float) -> MotionRecord:
        return replace(delayed(record, time), sensor_lag=lag.time)  # for the same samples

    delay = late_fit(fit, records, bench, model, late_effort)
    if delay is not None:
        searched = SearchedRecords.of(records, bench, IdentificationSettings(confidence))
        noise = [_smoothed_noise(searched, move, lag.time) for move in (delayed, sensed)]
        if NOTICEABLE * delay.square < lag.square + max(noise[0] - noise[1], 0.0):
            return None
    found = lag.regression.intervals()
    if "inertia" not in found or not contradicts(found["inertia"], bench.mechanics.inertia):
        return lag.interval
    if exchanged_inertia(found, lag.time, bench) is None:
        return lag.interval
    own = Interval.around(found["inertia"].value / found["viscous"].value, lag.rest.half_width)
    return None if may_be_read_apart(own.low, records) else own


def _smoothed_noise(searched: SearchedRecords, move: Move, time: float) -> float:
    """Return the mean square of the effort's noise after `move` by `time` [s] and smoothing.

    A lag suppresses more of the noise than a delay, so that its residual would be smaller.
    """
    squares, sizes = [], []
    for record, window in zip(searched.records, searched.windows, strict=True):
        n = record.effort.size
        impulse = np.zeros(n)
        impulse[n // 2] = 1.0
        alone = replace(record, effort=impulse, piece=np.zeros_like(record.piece))
        response = smoothed(move(alone, time), window)[2]
        squares.append(n * white_noise(record.effort) ** 2 * float(np.nansum(response**2)))
        sizes.append(n)
    return sum(squares) / sum(sizes)


def late_position(fit: SlidingFit | None, records: Sequence[MotionRecord]) -> Estimate | None:
    """Return the time [s] by which the position follows the effort in `fit`, or None.

    The time is that of a delay or lag in `fit`. The result is None if `fit` contains neither, or if
    the time may be shorter than the time between the readings of effort and position in one row of
    the log.
    """
    late = None if fit is None else fit.effects.get(DELAY)
    if late is None or may_be_read_apart(-late.high, records):
        return None
    return Estimate(
        value=-late.value, low=-late.high, high=-late.low, unit="s", source="identified"
    )


def lag_is_known(records: Sequence[MotionRecord], bench: Bench) -> bool:
    """Return whether the lag of the position need not be fitted.

    The result is True in three cases:

    - The bench states the lag of the position sensor.
    - The effort of a record was already filtered by this lag (`sensed`).
    - A record contains a measured velocity.
    """
    included = any(one.sensor_lag > 0.0 or one.velocity is not None for one in records)
    return included or bench.encoder.time_constant_s is not None


def may_be_read_apart(least: float, records: Sequence[MotionRecord]) -> bool:
    """Return whether effort and position of a row may be read at least `least` [s] apart."""
    return least <= READ_APART * max(one.period for one in records)


def exchanged_inertia(parameters: Mapping[str, Interval], lag: float, bench: Bench) -> float | None:
    """Return the inertia if the lag [s] and the time constant inertia/viscous are exchanged.

    `parameters` are the parameters with this lag. The result is None if the inertia is outside the
    interval in bench.yaml, or if the parameters lack the viscous friction.
    """
    viscous = parameters.get("viscous")
    low, high = bench.mechanics.inertia.interval
    if viscous is None or not low <= lag * viscous.value <= high:
        return None
    return lag * viscous.value
