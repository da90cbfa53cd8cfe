"""Measured bench properties of a model document, each with a value or the reason for no value."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from frictool.documents.bench import Bench
from frictool.documents.measurement import Measurement
from frictool.documents.quantity import Estimate, si_unit
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.measurement.loop_lag import loop_lag
from frictool.identify.measurement.reversals import reversals
from frictool.identify.measurement.winding import (
    BACK_EMF,
    INDUCTANCE,
    RESISTANCE,
    VOLTAGE_DROP,
)
from frictool.identify.motion_record import MotionRecord
from frictool.typing import Vector

NO_COMMAND = (
    "no log has both the commanded current (channel current_command) and the measured current"
)
DIMENSIONS = {
    "backlash": "position",
    "delay": "time",
    "loop_time_constant": "time",
    RESISTANCE: "resistance",
    BACK_EMF: "effort per ampere",
    INDUCTANCE: "inductance",
}


def measurement(
    records: list[MotionRecord],
    currents: list[tuple[Vector, Vector, float]],
    motor: Mapping[str, Interval | UnusableLogs],
    bench: Bench,
    confidence: float,
) -> Measurement:
    """Return backlash, delay, time constant of the current loop and constants of the winding.

    If the logs do not determine a property, the field `refused` of the result contains the reason.

    - records: records of sliding motion
    - currents: commanded current (n,) [A], measured current (n,) [A] and sample period [s] of each
      log that contains both currents
    - motor: properties of the winding, by name
    """
    try:
        width, late = (
            reversals(records, bench, confidence)
            if records
            else (UnusableLogs("no log of sliding motion was provided"),) * 2
        )
    except UnusableLogs as error:
        width = late = error
    lag = (
        _tried(lambda: loop_lag(*max(currents, key=lambda one: one[0].size), confidence))
        if currents
        else UnusableLogs(NO_COMMAND)
    )
    measured = {"backlash": width, "delay": late, "loop_time_constant": lag, **motor}
    refused = {name: str(one) for name, one in measured.items() if isinstance(one, UnusableLogs)}
    return Measurement(**_estimates(measured, bench), refused=refused)


def motor_measurement(
    motor: Mapping[str, Interval | UnusableLogs], bench: Bench
) -> Measurement | None:
    """Return the identified properties in `motor` (result of `winding`); None if there are none."""
    estimates = _estimates(motor, bench)
    return Measurement(**estimates, refused={}) if estimates else None


def _estimates(
    measured: Mapping[str, Interval | UnusableLogs], bench: Bench
) -> dict[str, Estimate]:
    return {
        name: one.estimate(DIMENSIONS[name], bench.axis)
        for name, one in measured.items()
        if isinstance(one, Interval) and name in DIMENSIONS
    }


def contradicting_constant(
    motor: Mapping[str, Interval | UnusableLogs], bench: Bench
) -> Interval | None:
    """Return the measured effort per ampere or volt if bench.yaml contradicts it, else None.

    `motor` is a result of `winding`. The effort per ampere of a DC motor is its back-EMF constant;
    the effort per volt is the ratio of back-EMF constant and resistance.
    """
    measured, resistance = motor.get(BACK_EMF), motor.get(RESISTANCE)
    if not isinstance(measured, Interval):
        return None
    if bench.actuator.drive == "voltage":
        if not isinstance(resistance, Interval):
            return None
        measured = Interval(
            measured.value / resistance.value,
            measured.low / resistance.high,
            measured.high / resistance.low,
        )
    low, high = bench.actuator.constant.interval
    return None if measured.low <= high and low <= measured.high else measured


def constant_warning(motor: Mapping[str, Interval | UnusableLogs], bench: Bench) -> str | None:
    """Return a warning if the back-EMF contradicts the effort constant in bench.yaml, else None.

    `motor` is a result of `winding`.
    """
    measured = contradicting_constant(motor, bench)
    if measured is None:
        return None
    constant = bench.actuator.constant
    low, high = constant.interval
    name = "back-EMF constant"
    if bench.actuator.drive == "voltage":
        name += "/resistance"
    return (
        f"actuator.constant [{low:.4g}, {high:.4g}] {constant.unit} contradicts the log's {name} "
        f"[{measured.low:.4g}, {measured.high:.4g}] of a DC motor; correct the constant: all "
        "efforts scale with it"
    )


def voltage_drop_warning(motor: Mapping[str, Interval | UnusableLogs], bench: Bench) -> str | None:
    """Return a warning that friction includes the voltage drop of driver and brushes, or None.

    The drive must be a voltage, and `motor`, a result of `winding`, must contain the drop.
    """
    drop = motor.get(VOLTAGE_DROP)
    if not isinstance(drop, Interval) or bench.actuator.drive != "voltage":
        return None
    effort = drop.value * bench.actuator.constant.value
    return (
        f"coulomb and breakaway include {effort:.3g} {si_unit('effort', bench.axis)}: driver and "
        f"brushes take {drop.value:.3g} V [{drop.low:.3g}, {drop.high:.3g}] of the logged voltage; "
        "to exclude this effort, subtract the drop"
    )


def _tried(estimate: Callable[[], Interval]) -> Interval | UnusableLogs:
    try:
        return estimate()
    except UnusableLogs as error:
        return error
