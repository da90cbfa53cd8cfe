"""Logs and a bench to a model: what `frictool identify` does, on values in memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.identification import Identification, NothingIdentified
from frictool.identify.identification import identify as identified
from frictool.identify.identification_logs import Currents, prepare_log, with_measurement
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.model_document import bench_model, model_of
from frictool.identify.motion_record import MotionRecord
from frictool.identify.presliding.presliding_laws import with_presliding
from frictool.identify.record_plausibility import repeats_plausibility_warning
from frictool.logs.log import Log


@dataclass(frozen=True)
class IdentifiedModel:
    """model: the document. result: what was found and refused, and why. records: of the `logs` that
    were given."""

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
    """Identify the axis of the bench from logs; return the model, each parameter with its interval.

    logs: logs of motion or of breakaway ramps; the kind is recognised. ramps: logs known to be
    breakaway ramps. loops: slow loops of the effort below the breakaway, for presliding.
    measurement: whether to estimate properties of the bench, too. method: a key of METHODS.
    keep_bench_values: if the logs give neither inertia nor friction, return a model of the bench's
    values, marked as such, instead of raising NothingIdentified. tell: callback for warnings about
    the logs. Raises NothingIdentified (a NothingUsable) with the reasons where the logs give
    neither inertia nor friction; LogError where a log is given twice, or cannot be one of this
    bench.
    """
    currents: list[Currents] = []
    records, slopes, slow = (
        _records(group, bench, currents, tell) for group in (logs, ramps, loops)
    )
    refuse_duplicates([*records, *slopes, *slow])
    alone = not (logs or ramps)
    origin = provenance or provenance_of_call("frictool.identify.identify", bench=bench)
    try:
        result = identified(records, slopes, bench, method, settings or IdentificationSettings())
        model = model_of(result, bench, origin)
    except NothingIdentified as error:
        result = error.result
        if alone and loops:
            model = model_of(result, bench, origin)  # the loops give presliding friction
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
    """The logs as records; where one holds commanded and measured current, both are added to
    `currents`."""
    found = []
    for given in logs:
        one = prepare_log(given, bench)
        for warning in one.log.warnings:
            if not repeats_plausibility_warning(warning, bench):
                tell(f"{Path(one.log.source).name}: {warning}")
        found.append(one.record)
        currents += [] if one.currents is None else [one.currents]
    return found
