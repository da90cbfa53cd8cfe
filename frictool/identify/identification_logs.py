"""Read log files into motion records, and add properties of the bench to a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace as with_fields

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.identification import Identification
from frictool.identify.measurement.bench_measurement import measurement
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log
from frictool.logs.reading import read_log
from frictool.typing import Vector

Currents = tuple[Vector, Vector, float]  # commanded and measured current (n,), A, and the period, s


@dataclass(frozen=True)
class IdentificationLog:
    """Log, its record, and its currents if both commanded and measured current are logged."""

    log: Log
    record: MotionRecord
    currents: Currents | None


def read_identification_log(path: Path, bench: Bench) -> IdentificationLog:
    """Return a log file prepared for identification; raise LogError if it is unusable."""
    return prepare_log(read_log(path, bench), bench)


def prepare_log(given: Log, bench: Bench) -> IdentificationLog:
    """Return a log in memory prepared for identification; raise LogError if it does not fit."""
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
    """Return the model with backlash, delay and current-loop lag estimated from the logs."""
    sliding = [record for record in records if result.kinds.get(record.name) == SLIDING_LOG]
    return with_fields(
        model, measurement=measurement(sliding, list(currents), model.bench, model.confidence)
    )
