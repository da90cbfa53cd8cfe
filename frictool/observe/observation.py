"""Observation of one log in one call, without files."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.log import Log
from frictool.logs.log_from_arrays import write_log
from frictool.logs.provenance import PROVENANCE, provenance_record
from frictool.observe.commissioning import Commissioning
from frictool.observe.estimates_log import write
from frictool.observe.log_observer import LogObserver, ObservationSettings
from frictool.observe.observation_outcome import ObservationOutcome, with_verdict
from frictool.runtime.object_view import ResultView


@dataclass(frozen=True, eq=False, repr=False)
class LogObservation(ResultView):
    """Result of `observe`.

    - outcome: final wear, velocity errors and verdict
    - estimates: log of velocity, friction and wear at each sample, with intervals
    """

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
    """Estimate velocity, friction and wear along a log; no estimate uses later samples.

    The returned estimates are in memory; for a log of many hours, use `LogObserver.parts`.

    Parameters
    ----------
    model : Model
        model of the axis and its bench
    log : Log, Path or str
        log in memory, or its path
    wear_limit : float, optional
        largest allowed wear [1]; if `commissioning` is passed, relative to the wear at
        commissioning
    commissioning : Commissioning, optional
        wear of the unit at commissioning
    observer : Observer, optional
        additional observer; a tracking observer replaces the velocity estimator
    settings : ObservationSettings, optional
        time window, stream, and confidence of the intervals
    provenance : Provenance, optional
        provenance of the estimates; by default it names this function

    Returns
    -------
    LogObservation
        outcome of the log, and estimates at each sample

    Raises
    ------
    LogError
        if the log cannot be read, or does not fit the model's bench
    DocumentError
        if observer and model have different kinds of axis, or observer and log different periods
    FrictoolError
        if the model has no dry friction
    """
    origin = provenance or provenance_of_call(
        "frictool.observe.observe", model=model, observer=observer
    )
    with tempfile.TemporaryDirectory() as temporary:
        path, estimates = Path(temporary, "log.mcap"), Path(temporary, "estimates.mcap")
        if isinstance(log, Log):
            write_log(log, path)
        else:
            path = Path(log)
        second = None if observer is None else (Path("observer"), observer)
        one = LogObserver(path, model, settings or ObservationSettings(), observer=second)
        with estimates.open("wb") as stream:
            write(one, one.parts(), stream, {PROVENANCE: provenance_record(origin)})
        return LogObservation(
            with_verdict(one.outcome(), wear_limit, commissioning), read_mcap(estimates)
        )
