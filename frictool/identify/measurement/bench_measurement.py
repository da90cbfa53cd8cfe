"""Document entry of the measured bench properties, each a value or a reason for its absence."""

from __future__ import annotations

from collections.abc import Callable

from frictool.documents.bench import Bench
from frictool.documents.measurement import Measurement
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.measurement.loop_lag import loop_lag
from frictool.identify.measurement.reversals import reversals
from frictool.identify.motion_record import MotionRecord
from frictool.typing import Vector

NO_COMMAND = (
    "no log holds both the commanded current (channel current_command) and the measured one"
)


def measurement(
    records: list[MotionRecord],
    currents: list[tuple[Vector, Vector, float]],
    bench: Bench,
    confidence: float,
) -> Measurement:
    """Return the measured bench properties.

    - records: records of sliding motion
    - currents: commanded and measured current (n,), A, and the period, s, of each log with both
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
    measured = {
        "backlash": (width, "position"),
        "delay": (late, "time"),
        "loop_time_constant": (lag, "time"),
    }
    estimates = {
        name: one.estimate(dimension, bench.axis)
        for name, (one, dimension) in measured.items()
        if isinstance(one, Interval)
    }
    refused = {
        name: str(one) for name, (one, _) in measured.items() if isinstance(one, UnusableLogs)
    }
    return Measurement(**estimates, refused=refused)


def _tried(estimate: Callable[[], Interval]) -> Interval | UnusableLogs:
    try:
        return estimate()
    except UnusableLogs as error:
        return error
