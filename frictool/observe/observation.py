"""A log observed in one call: what `frictool observe run` does of one log, on values in memory."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.in_memory import write_log
from frictool.logs.log import Log
from frictool.logs.provenance import PROVENANCE, provenance_record
from frictool.observe.commissioning import Commissioning
from frictool.observe.estimates_log import write
from frictool.observe.log_observer import LogObserver, ObservationSettings
from frictool.observe.observation_outcome import ObservationOutcome, with_verdict


@dataclass(frozen=True)
class LogObservation:
    """outcome: wear, velocity and verdict in the end. estimates: a log of what was known at every
    sample, with intervals."""

    outcome: ObservationOutcome
    estimates: Log


def observe(
    model: Model,
    log: Log | Path | str,
    *,
    wear_limit: float | None = None,
    commissioning: Commissioning | None = None,
    observer: Observer | None = None,
    settings: ObservationSettings | None = None,
    provenance: Provenance | None = None,
) -> LogObservation:
    """Velocity, friction and wear along a log, each from what was known at its sample; `log` in
    memory or at a path.

    wear_limit: of the wear, or of its ratio to `commissioning`. observer: a further one beside. The
    estimates are held in memory: of many hours, `observe.one_log.OneLog` gives them part by part.
    Raises LogError where the log is not of the model's bench.
    """
    origin = provenance or provenance_of_call(
        "frictool.observe.observe", model=model, observer=observer
    )
    with tempfile.TemporaryDirectory() as temporary:
        path, found = Path(temporary, "log.mcap"), Path(temporary, "estimates.mcap")
        if isinstance(log, Log):
            write_log(log, path)
        else:
            path = Path(log)
        beside = None if observer is None else (Path("observer"), observer)
        one = LogObserver(path, model, settings or ObservationSettings(), observer=beside)
        with found.open("wb") as stream:
            write(one, one.parts(), stream, {PROVENANCE: provenance_record(origin)})
        return LogObservation(
            with_verdict(one.outcome(), wear_limit, commissioning), read_mcap(found)
        )
