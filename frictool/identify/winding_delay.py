"""Inertia of an axis whose effort is late, because of a late voltage or of the winding.

For a voltage drive, with ' for the time derivative:

    effort(t) = inertia a + viscous v + ... + delay (effort)'        the whole effort acts late

A voltage that acts late delays the whole effort. The time constant L/R of the winding delays the
current, but not the back-EMF, which is a part of the viscous friction of a voltage drive. Let d be
the fitted delay, and B the part of the viscous friction that is not delayed. The inertia is then
larger by d B. For a late voltage, B is 0. For the winding, B is K^2/R, with the back-EMF constant K
and the resistance R; K^2/R is at most the viscous friction. If the bench states the lag of the
drive, the records contain the effort after this lag, which is a part of d.

If the log contains the motor current, too, `measurement/winding.py` identifies L, R and K. The
inertia is then larger by (L/R) K k, where k = K/R is the effort per volt.

A log of a current drive contains one current per sample period T. If the current is held between
the samples, only the delay of the readings is unknown. If instead the voltage of the winding is
held, the back-EMF changes the current between two samples. At the acceleration a, the mean of the
current i over a period then differs from the mean of the two readings by

    g i' + g K a/R        g = T (coth(r/2)/2 - 1/r), r = R T/L

for readings before the updates of the voltage, and by the negative of this expression for readings
after the updates. A fit with a delay contains the first term: g is the fitted delay relative to the
mean of two readings. The second term changes the inertia by g K^2/R, at most T/2 K^2/R
(`current_between_samples`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.fit_result import DIMENSIONS, Interval
from frictool.identify.measurement.bench_measurement import contradicting_constant
from frictool.identify.measurement.winding import (
    BACK_EMF,
    INDUCTANCE,
    RESISTANCE,
    winding_of_records,
)
from frictool.identify.motion_record import JITTER, READ_APART, MotionRecord, fitted_sensor_lag
from frictool.identify.rows.effects import DELAY

WHAT = "the inductance of the winding"
BETWEEN_SAMPLES = "the current between two samples"


@dataclass(frozen=True)
class WindingDelay:
    """Increase of the inertia if the winding causes a part of the fitted delay, kg m^2 | kg.

    - possible: increase if the winding causes the whole delay, and the back-EMF causes the whole
      viscous friction; the interval does not extend below 0
    - measured: increase by the measured winding, at most `possible`; None if it was not measured
    - lag: electrical time constant L/R of the measured winding, s; 0 if it was not measured
    - undecided: reason why the logged current does not determine the increase, as the predicate of
      a sentence; empty if no current was logged, or if the logged current determines the increase
    """

    possible: Interval
    measured: Interval | None = None
    lag: float = 0.0
    undecided: str = ""

    @property
    def effects(self) -> list[AcceptedEffects]:
        """Return the possible shift of the inertia if the winding was not measured, else []."""
        if self.measured is not None:
            return []
        scatter = {"inertia": self.possible.half_width}
        shift = {"inertia": self.possible.value}
        return [AcceptedEffects((WHAT,), 1.0, shift, scatter=scatter, one_sided=True)]

    def corrected(self, inertia: Interval) -> Interval:
        """Return `inertia`, from a fit that delays the whole effort, plus the measured increase."""
        more = self.measured
        if more is None:
            return inertia
        below = math.hypot(inertia.value - inertia.low, more.value - more.low)
        above = math.hypot(inertia.high - inertia.value, more.high - more.value)
        value = inertia.value + more.value
        return Interval(value, value - below, value + above)

    def warning(self, inertia: Interval, bench: Bench) -> str:
        """Return a warning about the delay; `inertia` is the final interval of the inertia."""
        unit = si_unit("inertia", bench.axis)
        if self.measured is not None:
            return (
                f"inertia: {self.measured.value:.3g} {unit} were added, since the winding (L/R = "
                f"{1e3 * self.lag:.3g} ms, from voltage and current) delays the current but not "
                "the back-EMF"
            )
        advice = "to decide, also log the current (columns.current)"
        if self.undecided:
            advice = f"the logged current {self.undecided}"
        return (
            f"inertia: {inertia.value:.4g} {unit} if the voltage acts late, up to "
            f"{inertia.high:.4g} if the winding's L/R delays the current; {advice}"
        )


def winding_delay(
    regression: EffectRegression | None,
    viscous: float,
    records: Sequence[MotionRecord],
    bench: Bench,
) -> WindingDelay | None:
    """Return the increase of the inertia due to the winding of a voltage drive.

    `viscous` is the viscous friction of the fit. Return None in five cases: the drive is no voltage
    drive; the effort was measured; the model lacks the inertia; neither the model contains a delay
    nor the records contain a lag; the computed increase is not positive.
    """
    if regression is None or not _behind_winding(records, bench):
        return None
    alone = regression.intervals().get("inertia")
    most = regression.inertia_with_undelayed_viscous(viscous)
    stated = viscous * max(record.lag + fitted_sensor_lag(record, bench) for record in records)
    if alone is None or (most is None and stated == 0.0):
        return None
    increase = stated + (0.0 if most is None else most.value - alone.value)
    if increase <= 0.0:
        return None
    half = 0.0 if most is None else most.half_width
    return _of_current(Interval.around(increase, half, 0.0), records, bench, regression.confidence)


def _of_current(
    possible: Interval, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> WindingDelay:
    """Return the possible increase of the inertia, and the increase by a measured winding.

    The increase is not measured if no log contains the current, if the logs do not determine the
    winding, if its effort per volt contradicts `actuator.constant`, or if the whole interval of the
    increase is above `possible`.
    """
    found = winding_of_records(records, confidence)
    if not found:
        return WindingDelay(possible)
    known = [found.get(name) for name in (RESISTANCE, BACK_EMF, INDUCTANCE)]
    resistance, back_emf, inductance = known
    if not (
        isinstance(resistance, Interval)
        and isinstance(back_emf, Interval)
        and isinstance(inductance, Interval)
    ):
        return WindingDelay(possible, undecided="does not determine L/R, R and back-EMF")
    constant = bench.actuator.constant
    if contradicting_constant(found, bench) is not None:
        return WindingDelay(possible, undecided="contradicts actuator.constant")
    lag = inductance.value / resistance.value
    least = constant.value * back_emf.low * inductance.low / resistance.high
    most = constant.value * back_emf.high * inductance.high / resistance.low
    if least > possible.high:
        return WindingDelay(possible, undecided="shows an L/R that exceeds the delay of the effort")
    value = min(constant.value * back_emf.value * lag, possible.high)
    return WindingDelay(possible, Interval(value, least, min(most, possible.high)), lag)


def current_between_samples(
    regression: EffectRegression | None, records: Sequence[MotionRecord], bench: Bench
) -> list[AcceptedEffects]:
    """Return the shift of the inertia if a current drive holds the voltage between two samples.

    The result is empty if the drive is no current drive, or if the bench states the lag of the
    current. A logged voltage that explains the current determines the resistance R, the back-EMF
    constant and usually the inductance L. Without such a voltage, the bench has to state R, and the
    fitted delay has to exceed half a sample period T: readings of a current that is held between
    samples have no such delay. If L is unknown, the largest possible shift is returned. The shift
    is positive if the fitted delay exceeds T/2, else negative. Without a fitted delay, both signs
    are possible.
    """
    actuator = bench.actuator
    if regression is None or actuator.drive != "current" or actuator.logged_lag_s > 0.0:
        return []
    delay = regression.intervals().get(DELAY)
    period = max(record.period for record in records)
    between = 0.0 if delay is None else delay.value - 0.5 * period
    found = winding_of_records(records, regression.confidence)
    resistance, back_emf, inductance = (
        found.get(name) for name in (RESISTANCE, BACK_EMF, INDUCTANCE)
    )
    share = 0.5
    if isinstance(resistance, Interval) and isinstance(back_emf, Interval) and resistance.low > 0.0:
        damping = back_emf.high / resistance.low
        if isinstance(inductance, Interval) and inductance.low > 0.0:
            ratio = period * resistance.high / inductance.low
            share = 0.5 / math.tanh(0.5 * ratio) - 1.0 / ratio
    elif actuator.winding is not None and between > 0.0:
        damping = actuator.constant.interval[1] / actuator.winding.resistance_ohm
    else:
        return []
    shift = math.copysign(actuator.constant.value * damping * share * period, between)
    return [
        AcceptedEffects((BETWEEN_SAMPLES,), 1.0, {"inertia": shift}, one_sided=delay is not None)
    ]


def undeclared_winding(
    regression: EffectRegression | None, records: Sequence[MotionRecord], bench: Bench
) -> str | None:
    """Return a warning if the winding may change a current between samples, but R is unknown.

    R is the resistance. The lower end of the fitted delay is then between a half and about one
    sample period. `current_between_samples` has no result in this case.
    """
    actuator = bench.actuator
    if regression is None or actuator.drive != "current" or actuator.logged_lag_s > 0.0:
        return None
    delay = regression.intervals().get(DELAY)
    period = max(record.period for record in records)
    if actuator.winding is not None or delay is None or not 0.5 < delay.low / period < 1.0 + JITTER:
        return None
    return (
        f"inertia: the current acts {1e3 * delay.value:.3g} ms before its sample; if the voltage "
        "is held, the back-EMF makes the inertia larger; log the voltage, or state actuator.winding"
    )


def lag_doubts(
    records: Sequence[MotionRecord],
    bench: Bench,
    regression: EffectRegression,
    wide: Mapping[str, Interval],
) -> list[tuple[str, str]]:
    """Return [(parameter, warning)] for parameters that an unknown lag of a winding can change.

    The lag is assumed to exceed the delay of the model (0 without a delay) by at most one sample
    period. There is no warning if the effort was measured, if one period of lag moves each
    parameter by less than the half width of its interval, or if the interval of the fitted delay
    ends below the delay of the model plus READ_APART periods. The interval of the fitted delay is
    not used if noise of the acceleration falsifies the delay, or if the whole interval means that
    the voltage acts before it is logged.
    """
    late = next((one for one in regression.hypotheses if one.term == DELAY), None)
    known = any(one.lag > 0.0 or one.winding is not None for one in records)
    if late is None or known or not _behind_winding(records, bench):
        return []
    period = max(record.period for record in records)
    without = regression.without(late)
    found = without.intervals([late]).get(DELAY)
    fitted = max(-found.value, 0.0) if found is not None and late in regression.used else 0.0
    most = fitted + READ_APART * period
    if not regression.noisy and found is not None and 0.0 <= -found.low < most:
        return []
    rates = {n: one for n, one in without.rates(late).items() if n in wide and one != 0.0}
    name = min(rates, key=lambda one: wide[one].half_width / abs(rates[one]), default=None)
    if name is None or wide[name].half_width >= period * abs(rates[name]):
        return []
    shown = f"{1e-3 * abs(rates[name]):.2g} {si_unit(DIMENSIONS[name], bench.axis)}"
    doubt = (
        f"{name} changes by about {shown} per ms of the winding's time constant L/R, which is "
        "unknown; state L/R in actuator.loop_time_constant_s, or log the current "
        "(columns.current)"
    )
    return [(name, doubt)]


def _behind_winding(records: Sequence[MotionRecord], bench: Bench) -> bool:
    """Return True if a winding delays the effort behind its logged value."""
    computed = any(not record.effort_measured for record in records)
    return bench.actuator.winding_delays and computed
