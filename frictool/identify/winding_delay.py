"""Inertia of a voltage drive whose effort is delayed by the voltage or by the winding.

    effort(t) = inertia a + viscous v + ... + delay (effort)'        the whole effort acts late

A voltage that acts late delays the whole effort. The time constant L/R of the winding delays the
current, but not the back-EMF, which is a part of the viscous friction of a voltage drive. Let d be
the fitted delay, and B the part of the viscous friction that is not delayed. The inertia is then
larger by d B. For a late voltage, B is 0. For the winding, B is K^2/R, with the back-EMF constant K
and the resistance R. This is at most the viscous friction.

If the log contains the motor current, too, `measurement/winding.py` identifies L, R and K. The
inertia is then larger by (L/R) K k, where k = K/R is the effort per volt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.measurement.winding import (
    BACK_EMF,
    INDUCTANCE,
    RESISTANCE,
    winding,
    winding_log,
)
from frictool.identify.motion_record import MotionRecord, once_per_record

WHAT = "the inductance of the winding"


@dataclass(frozen=True)
class WindingDelay:
    """Increase of the inertia if the winding causes a part of the delay.

    - possible: increase if the winding causes the whole delay and its back-EMF the whole viscous
      friction; the interval does not extend below 0
    - measured: increase by the measured winding, at most `possible`; None if it was not measured
    - lag: electrical time constant L/R of the measured winding, s; 0 if it was not measured
    """

    possible: Interval
    measured: Interval | None = None
    lag: float = 0.0

    @property
    def effects(self) -> list[AcceptedEffects]:
        """Return the possible shift of the inertia if the winding was not measured, else []."""
        if self.measured is not None:
            return []
        scatter = {"inertia": self.possible.half_width}
        shift = {"inertia": self.possible.value}
        return [AcceptedEffects((WHAT,), 1.0, shift, scatter=scatter, one_sided=True)]

    def corrected(self, inertia: Interval) -> Interval:
        """Return the inertia of a fit that delays the whole effort, plus the measured increase."""
        more = self.measured
        if more is None:
            return inertia
        below = math.hypot(inertia.value - inertia.low, more.value - more.low)
        above = math.hypot(inertia.high - inertia.value, more.high - more.value)
        value = inertia.value + more.value
        return Interval(value, value - below, value + above)

    def warning(self, inertia: Interval, bench: Bench) -> str:
        """Return a warning of the delay; `inertia` is the final interval of the inertia."""
        unit = si_unit("inertia", bench.axis)
        if self.measured is not None:
            return (
                f"inertia: {self.measured.value:.3g} {unit} were added, since the winding (L/R = "
                f"{1e3 * self.lag:.3g} ms, from voltage and current) delays the current but not "
                "the back-EMF"
            )
        return (
            f"inertia: {inertia.value:.4g} {unit} if the voltage acts late, up to "
            f"{inertia.high:.4g} if the winding's L/R delays the current; to decide, also log the "
            "current (columns.current)"
        )


def winding_delay(
    regression: EffectRegression | None,
    viscous: float,
    records: Sequence[MotionRecord],
    bench: Bench,
) -> WindingDelay | None:
    """Return the increase of the inertia by the winding of a voltage drive.

    `viscous` is the viscous friction of the fit. Return None for another drive, if the model lacks
    the delay or the inertia, or if the effort does not act late.
    """
    if regression is None or bench.actuator.drive != "voltage" or bench.actuator.servo is not None:
        return None
    alone = regression.intervals().get("inertia")
    most = regression.undelayed_viscous(viscous)
    if alone is None or most is None or most.value <= alone.value:
        return None
    possible = Interval.around(most.value - alone.value, most.half_width, 0.0)
    return _measured_delay(possible, records, bench, regression.confidence) or WindingDelay(
        possible
    )


def _measured_delay(
    possible: Interval, records: Sequence[MotionRecord], bench: Bench, confidence: float
) -> WindingDelay | None:
    """Return the delay with a measured increase, or None if the logs do not determine it.

    The result is also None if K/R contradicts `actuator.constant`, or if the whole interval of the
    increase is above `possible`.
    """
    logged = [record for record in records if record.winding is not None]
    found = _winding(logged[0], tuple(logged[1:]), confidence) if logged else {}
    known = [found.get(name) for name in (RESISTANCE, BACK_EMF, INDUCTANCE)]
    resistance, back_emf, inductance = known
    if not (
        isinstance(resistance, Interval)
        and isinstance(back_emf, Interval)
        and isinstance(inductance, Interval)
    ):
        return None
    constant = bench.actuator.constant
    low, high = constant.interval
    if back_emf.low / resistance.high > high or back_emf.high / resistance.low < low:
        return None
    lag = inductance.value / resistance.value
    least = constant.value * back_emf.low * inductance.low / resistance.high
    most = constant.value * back_emf.high * inductance.high / resistance.low
    if least > possible.high:
        return None
    value = min(constant.value * back_emf.value * lag, possible.high)
    return WindingDelay(possible, Interval(value, least, min(most, possible.high)), lag)


@once_per_record
def _winding(
    record: MotionRecord, others: tuple[MotionRecord, ...], confidence: float
) -> dict[str, Interval | UnusableLogs]:
    """Return resistance, back-EMF constant and inductance [SI], or the reasons for unknown ones."""
    logs = [log for one in (record, *others) if (log := winding_log(one)) is not None]
    return winding(logs, confidence)
