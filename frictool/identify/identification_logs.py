"""From log files to the records that methods start from, and what they tell of the bench itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace as with_fields

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.identify.identification import SLIDING_LOG, Identification
from frictool.identify.measurement.bench_measurement import measurement
from frictool.identify.motion_record import MotionRecord, Vector, record_of
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log
from frictool.logs.reading import read_log

Currents = tuple[Vector, Vector, float]  # commanded and measured (n,) A, and the period


@dataclass(frozen=True)
class IdentificationLog:
    """A log, its record, and its currents where it holds commanded and measured ones. The log's
    warnings are of what let pass."""

    log: Log
    record: MotionRecord
    currents: Currents | None


def read_identification_log(path: Path, bench: Bench) -> IdentificationLog:
    """Raises LogError where it cannot be read, or has not what a record needs."""
    return prepare_log(read_log(path, bench), bench)


def prepare_log(given: Log, bench: Bench) -> IdentificationLog:
    """A log in memory. Raises LogError where it is not of this bench, or has not what a record
    needs."""
    log = match_bench(given, bench)
    record = record_of(log, bench)
    signals = log.main.signals
    both = {"current_command", "current"} <= signals.keys()
    return IdentificationLog(
        log,
        record,
        (signals["current_command"], signals["current"], record.period) if both else None,
    )


def with_measurement(
    model: Model,
    result: Identification,
    records: Sequence[MotionRecord],
    currents: Sequence[Currents],
) -> Model:
    """The model with what the logs tell of the bench."""
    sliding = [record for record in records if result.kinds.get(record.name) == SLIDING_LOG]
    return with_fields(
        model, measurement=measurement(sliding, list(currents), model.bench, model.confidence)
    )
