"""Measured bench properties of a model document, each with a value or the reason for no value."""

from __future__ import annotations

from collections.abc import Callable

from frictool.documents.bench import Bench
from frictool.documents.measurement import Measurement
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.measurement.loop_lag import loop_lag
from frictool.identify.measurement.reversals import reversals
from frictool.identify.measurement.winding import (
    BACK_EMF,
    INDUCTANCE,
    RESISTANCE,
    WindingLog,
    winding,
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
    windings: list[WindingLog],
    bench: Bench,
    confidence: float,
) -> Measurement:
    """Return backlash, delay, time constant of the current loop and constants of the winding.

    If the logs do not determine a property, `refused` contains the reason.

    - records: records of sliding motion
    - currents: commanded current (n,) [A], measured current (n,) [A] and sample period [s] of each
      log that contains both currents
    - windings: voltage, current and position of each log that contains all three signals
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
    measured = {"backlash": width, "delay": late, "loop_time_constant": lag}
    if windings:
        measured |= winding(windings, confidence)
    estimates = {
        name: one.estimate(DIMENSIONS[name], bench.axis)
        for name, one in measured.items()
        if isinstance(one, Interval)
    }
    refused = {name: str(one) for name, one in measured.items() if isinstance(one, UnusableLogs)}
    return Measurement(**estimates, refused=refused)


def constant_warning(measured: Measurement, bench: Bench) -> str | None:
    """Return a warning if the back-EMF contradicts the effort constant in bench.yaml, else None."""
    back_emf, resistance = measured.back_emf_constant, measured.resistance
    constant = bench.actuator.constant
    if back_emf is None:
        return None
    name = "back-EMF constant"
    low, high = back_emf.interval
    if bench.actuator.drive == "voltage":
        if resistance is None:
            return None
        name = "ratio of back-EMF constant and resistance"
        low, high = low / resistance.interval[1], high / resistance.interval[0]
    if low <= constant.interval[1] and constant.interval[0] <= high:
        return None
    return (
        f"actuator.constant: the measured {name} is [{low:.4g}, {high:.4g}] {constant.unit}, and "
        f"the bench states {constant.value:.4g}; for a DC motor both are equal: correct the bench, "
        "or the units"
    )


def _tried(estimate: Callable[[], Interval]) -> Interval | UnusableLogs:
    try:
        return estimate()
    except UnusableLogs as error:
        return error
