"""Trial of the identification methods on a log: the reasons why they would refuse the log.

The trial identifies the log with the bench, as `identify` does. Least squares are tried first.

- If least squares accept the log, the methods in ALIKE are not tried. These methods use the samples
  of least squares with other weights, or start a search with least squares (`auto`,
  `output-error`). They are reported as accepting the log if they support log and bench.
- If least squares refuse the log for one common reason, this reason is reported for every method.
  The reason is common if it concerns the whole log, or is the same for all parameters.
- Otherwise, each method is tried.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.errors import FrictoolError
from frictool.identify.applicable_methods import BREAKAWAY
from frictool.identify.axis_logs import RAMP_LOG
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.methods import (
    DEFAULT,
    METHODS,
    REFERENCE,
    IdentificationSettings,
    refuse_unsupported,
)
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.identify.servo_identification import METHODS as SERVO_METHODS
from frictool.identify.servo_identification import identify_servo
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log

SETTINGS = IdentificationSettings()
# methods that accept a log if least squares accept the log
ALIKE = (
    DEFAULT,
    "power-balance",
    "weighted",
    "conditioned",
    "weak",
    "total-least-squares",
    "recursive",
    "output-error",
)
NO_EFFORT = "the bench has actuator.servo, which measures no effort"


def tried_methods(
    log: Log, bench: Bench, reasons: Mapping[str, str | None]
) -> dict[str, str | None]:
    """Return for each method the reason why `identify` refuses a log; None if it accepts the log.

    `reasons` is the result of `applicable_methods`. Methods with a reason in `reasons` are not
    tried.
    """
    try:
        record = record_of(match_bench(log, bench), bench)
    except FrictoolError as error:
        return dict.fromkeys(reasons, _reason(error, log.source))
    if bench.actuator.servo is not None:
        return _tried_servo(record, bench, reasons)
    why = {name: one for name, one in reasons.items() if one is not None}
    if REFERENCE not in why:
        try:
            identify_records([record], [], bench, REFERENCE, SETTINGS)
        except FrictoolError as error:
            why[REFERENCE] = _reason(error, record.name)
            if _of_the_log(error):
                return {name: why.get(name, why[REFERENCE]) for name in reasons}
    accepted = REFERENCE not in why
    for name in METHODS.keys() - {REFERENCE} - why.keys():
        known = accepted and name in ALIKE
        refusal = (_unsupported if known else _refusal)(record, bench, name)
        if refusal is not None:
            why[name] = refusal
    if BREAKAWAY not in why:
        refusal = _breakaway_refusal(record, bench)
        if refusal is not None:
            why[BREAKAWAY] = refusal
    return {name: why.get(name) for name in reasons}


def _of_the_log(error: FrictoolError) -> bool:
    """Return True if `error` concerns the whole log, or has the same reason for all parameters."""
    return not isinstance(error, NothingIdentified) or len(set(error.result.refused.values())) == 1


def _unsupported(record: MotionRecord, bench: Bench, method: str) -> str | None:
    try:
        refuse_unsupported(method, [record], bench)
    except FrictoolError as error:
        return _reason(error, record.name)
    return None


def _refusal(record: MotionRecord, bench: Bench, method: str) -> str | None:
    try:
        identify_records([record], [], bench, method, SETTINGS)
    except FrictoolError as error:
        return _reason(error, record.name)
    return None


def _breakaway_refusal(record: MotionRecord, bench: Bench) -> str | None:
    try:
        result = identify_records([record], [], bench, DEFAULT, SETTINGS)
    except FrictoolError as error:
        return _reason(error, record.name)
    if result.kinds[record.name] == RAMP_LOG and "breakaway" in result.identified:
        return None
    return result.refused.get("breakaway")


def _tried_servo(
    record: MotionRecord, bench: Bench, reasons: Mapping[str, str | None]
) -> dict[str, str | None]:
    why: str | None = None
    try:
        identify_servo([record], bench, DEFAULT, SETTINGS)
    except FrictoolError as error:
        why = _reason(error, record.name)
    return {name: why if name in SERVO_METHODS else NO_EFFORT for name in reasons}


def _reason(error: FrictoolError, source: str) -> str:
    return str(error).replace(source, Path(source).name)
