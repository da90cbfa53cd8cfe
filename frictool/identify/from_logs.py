"""Identification of a model from logs and a bench: `frictool identify` without reading files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.missing_effects import missing_ringing
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.breakaway.rate_table import breakaway_over_rate
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.fitted_lag import late_position
from frictool.identify.identification import Identification, NothingIdentified, identify_records
from frictool.identify.measurement.bench_measurement import (
    constant_warning,
    measurement,
    motor_measurement,
    voltage_drop_warning,
)
from frictool.identify.measurement.resonance_in_motion import resonance_in_motion
from frictool.identify.measurement.ringing import ringing
from frictool.identify.measurement.winding import winding_of_records
from frictool.identify.methods import IdentificationRequest
from frictool.identify.model_document import bench_model, model_of
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.identify.presliding.presliding_laws import with_presliding
from frictool.identify.record_plausibility import repeats_plausibility_warning
from frictool.identify.rest_balance import held_rest_warnings
from frictool.identify.servo_identification import identify_servo
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log
from frictool.runtime.object_view import ResultView
from frictool.typing import Vector

USUAL = IdentificationRequest()


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiedModel(ResultView):
    """Model of an axis, with the identification result and the records of the logs.

    - result: identified and refused parameters, with reasons
    - records: records of the logs that `identify` received as `logs`
    - ramps: records of the logs that `identify` received as `ramps`
    """

    model: Model
    result: Identification
    records: tuple[MotionRecord, ...]
    ramps: tuple[MotionRecord, ...] = ()


def identify(
    logs: Sequence[Log],
    bench: Bench,
    request: IdentificationRequest = USUAL,
    *,
    ramps: Sequence[Log] = (),
    loops: Sequence[Log] = (),
    provenance: Provenance | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> IdentifiedModel:
    """Identify the axis of a bench from logs.

    Parameters
    ----------
    logs
        Logs of motion or of breakaway ramps; the kind of each log is detected.
    bench
        Bench on which the logs were recorded.
    request
        Method, settings, and additional estimates.
    ramps
        Logs of breakaway ramps; their kind is not detected.
    loops
        Logs of slow effort loops below the breakaway, for presliding friction.
    provenance
        Provenance of the model; the default provenance names this function.
    tell
        Callback for warnings about the logs.

    Returns
    -------
    IdentifiedModel
        Model with an interval for each parameter in SI units, and the identification result.

    Raises
    ------
    NothingIdentified
        If the logs give neither inertia nor friction, or if position and drive have opposite signs.
        The message states the reasons.
    UnusableLogs
        If only `loops` are passed and they do not determine presliding friction.
    LogError
        If two logs are the same, or a log cannot come from this bench.
    """
    prepared = [[_prepared(log, bench, tell) for log in group] for group in (logs, ramps, loops)]
    records, slopes, slow = ([one.record for one in group] for group in prepared)
    refuse_duplicates([*records, *slopes, *slow])
    loops_alone = bool(loops) and not (logs or ramps)
    origin = provenance or provenance_of_call("frictool.identify.identify", bench=bench)
    if bench.actuator.servo is not None:
        return _identify_servo(bench, request, origin, records, [*slopes, *slow])
    try:
        result = identify_records(records, slopes, bench, request.method, request.settings)
        if request.breakaway_table is not None:
            over_rate = breakaway_over_rate(request.breakaway_table, request.settings.confidence)
            result = result.with_table(over_rate, bench)
        model = model_of(result, bench, origin)
    except NothingIdentified as error:
        result = error.result
        if loops_alone:
            model = model_of(result, bench, origin)  # loops give presliding friction only
        elif request.keep_bench_values:
            model = bench_model(error, bench, origin)
        else:
            raise
    if loops:
        model = with_presliding(model, slow)
        if loops_alone and model.presliding is None:
            raise UnusableLogs(f"presliding: {model.not_identified['presliding']}")
        result = replace(result, refused=model.not_identified)
    confidence = request.settings.confidence
    motor = {}
    if request.measurement or bench.actuator.drive == "voltage":
        motor = winding_of_records([*records, *slopes, *slow], confidence)
    doubts = [constant_warning(motor, bench), voltage_drop_warning(motor, bench)]
    result = replace(result, warnings=(*result.warnings, *filter(None, doubts)))
    if motor and not request.measurement:
        model = msgspec.structs.replace(model, measurement=motor_measurement(motor, bench))
    model = msgspec.structs.replace(
        model,
        ringing=ringing([*records, *slopes], model)
        or resonance_in_motion(records, model.parameters.inertia.value),
        late_position=late_position(result.fit, records),
    )
    missing = missing_ringing(model)
    if missing is not None:
        result = replace(result, warnings=(*result.warnings, missing))
    sliding = [one for one in (*records, *slopes) if result.kinds.get(one.name) == SLIDING_LOG]
    if result.fit is not None:
        held = held_rest_warnings(model, sliding)
        result = replace(result, warnings=(*result.warnings, *held))
    if request.measurement:
        currents = [one.currents for group in prepared for one in group if one.currents]
        measured = measurement(sliding, currents, motor, bench, confidence)
        model = msgspec.structs.replace(model, measurement=measured)
    return IdentifiedModel(model, result, tuple(records), tuple(slopes))


def _identify_servo(
    bench: Bench,
    request: IdentificationRequest,
    origin: Provenance,
    records: list[MotionRecord],
    others: list[MotionRecord],
) -> IdentifiedModel:
    if others or request.breakaway_table is not None or request.measurement:
        raise UnusableLogs(
            "a bench with actuator.servo has no measured effort, which --ramp, --loops, "
            "--breakaway-table and --measurement need; leave these options out"
        )
    servo = identify_servo(records, bench, request.method, request.settings)
    return IdentifiedModel(
        model_of(servo.result, servo.bench, origin), servo.result, tuple(records)
    )


@dataclass(frozen=True)
class PreparedLog:
    """Record of a log, and the currents in this log.

    - currents: commanded current (n,) [A], measured current (n,) [A] and sample period [s]; None if
      the log lacks one of the currents
    """

    record: MotionRecord
    currents: tuple[Vector, Vector, float] | None


def _prepared(log: Log, bench: Bench, tell: Callable[[str], None]) -> PreparedLog:
    log = match_bench(log, bench)
    record = record_of(log, bench)
    signals = log.main.signals
    for warning in log.warnings:
        if not repeats_plausibility_warning(warning, bench):
            tell(f"{Path(log.source).name}: {warning}")
    currents = None
    if {"current_command", "current"} <= signals.keys():
        currents = (signals["current_command"], signals["current"], record.period)
    return PreparedLog(record, currents)
