"""Identify a model document from logs and a bench in memory, as `frictool identify` does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.identification import (
    Identification,
    NothingIdentified,
    identify_records,
)
from frictool.identify.identification_logs import Currents, prepare_log, with_measurement
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.model_document import bench_model, model_of
from frictool.identify.motion_record import MotionRecord
from frictool.identify.presliding.presliding_laws import with_presliding
from frictool.identify.record_plausibility import repeats_plausibility_warning
from frictool.logs.log import Log


@dataclass(frozen=True)
class IdentifiedModel:
    """Model of an axis and the identification behind it.

    - model: model document
    - result: identified and refused parameters, with reasons
    - records: records of the `logs` argument, without ramps and loops
    """

    model: Model
    result: Identification
    records: tuple[MotionRecord, ...]


def identify(
    logs: Sequence[Log],
    bench: Bench,
    *,
    ramps: Sequence[Log] = (),
    loops: Sequence[Log] = (),
    measurement: bool = False,
    method: str = DEFAULT,
    settings: IdentificationSettings | None = None,
    keep_bench_values: bool = False,
    provenance: Provenance | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> IdentifiedModel:
    """Identify the axis of a bench from logs.

    Parameters
    ----------
    logs
        Logs of motion or of breakaway ramps; the kind of each log is detected.
    bench
        Bench that the logs were recorded on.
    ramps
        Logs that are known to be breakaway ramps.
    loops
        Logs of slow effort loops below the breakaway, for presliding friction.
    measurement
        Also estimate properties of the bench, such as backlash and delay.
    method
        Key of METHODS.
    settings
        Confidence and options of the method; the defaults if None.
    keep_bench_values
        If the logs give neither inertia nor friction, return a model of the bench's values, marked
        as such, instead of raising NothingIdentified.
    provenance
        Provenance of the model; by default it names this call.
    tell
        Callback for warnings about the logs.

    Returns
    -------
    IdentifiedModel
        Model with an interval for each parameter in SI units, and the identification behind it.

    Raises
    ------
    NothingIdentified
        If the logs give neither inertia nor friction, or if position and drive have opposite signs.
        The message holds the reasons.
    UnusableLogs
        If only `loops` are passed and they do not give presliding friction.
    LogError
        If two logs are the same, or a log cannot be of this bench.
    """
    currents: list[Currents] = []
    records, slopes, slow = (
        _records(group, bench, currents, tell) for group in (logs, ramps, loops)
    )
    refuse_duplicates([*records, *slopes, *slow])
    alone = not (logs or ramps)
    origin = provenance or provenance_of_call("frictool.identify.identify", bench=bench)
    try:
        result = identify_records(
            records, slopes, bench, method, settings or IdentificationSettings()
        )
        model = model_of(result, bench, origin)
    except NothingIdentified as error:
        result = error.result
        if alone and loops:
            model = model_of(result, bench, origin)  # loops give presliding friction only
        elif keep_bench_values:
            model = bench_model(error, bench, origin)
        else:
            raise
    if loops:
        model = with_presliding(model, slow)
        if alone and model.presliding is None:
            raise UnusableLogs(f"presliding: {model.not_identified['presliding']}")
        result = replace(result, refused=model.not_identified)
    if measurement:
        model = with_measurement(model, result, [*records, *slopes], currents)
    return IdentifiedModel(model, result, tuple(records))


def _records(
    logs: Sequence[Log], bench: Bench, currents: list[Currents], tell: Callable[[str], None]
) -> list[MotionRecord]:
    """Return the records of the logs; append commanded and measured currents to `currents`."""
    found = []
    for given in logs:
        one = prepare_log(given, bench)
        for warning in one.log.warnings:
            if not repeats_plausibility_warning(warning, bench):
                tell(f"{Path(one.log.source).name}: {warning}")
        found.append(one.record)
        currents += [] if one.currents is None else [one.currents]
    return found
