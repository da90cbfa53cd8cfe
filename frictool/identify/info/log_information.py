"""Survey of a log and of the methods that can use the log: the function behind `frictool info`.

file -> assemble() -> streams, each read twice -> logs/quality/survey.py
     -> StreamSurvey per stream -> facts -> text_view.py -> text
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.applicable_methods import DRIVES, applicable_methods
from frictool.logs.canonical.mcap_layout import COLUMNS, KIND, message_path
from frictool.logs.clocks.alignment import CLOCK_OFFSET
from frictool.logs.clocks.clock_drift import of_streams
from frictool.logs.log import Log
from frictool.logs.log_assembly import (
    EVERYTHING,
    LogAssembly,
    TimeWindow,
    assemble,
    origins,
    start_streams,
)
from frictool.logs.log_from_arrays import write_log
from frictool.logs.losses import as_rows
from frictool.logs.quality.kind_recognition import kind_of
from frictool.logs.quality.log_kinds import TEST
from frictool.logs.quality.motion_check import motion_doubts
from frictool.logs.quality.sign_check import sign_of
from frictool.logs.quality.survey import StreamSurvey, row, survey
from frictool.logs.raw_table import LAYOUT
from frictool.runtime.object_view import ResultView


@dataclass(frozen=True, eq=False, repr=False)
class Information(ResultView):
    """Survey of a log.

    - facts: output of `--json`: one row per signal, and properties of the whole log
    - surveys: survey of each stream
    - assembly: streams of the log, as read from the file
    """

    facts: dict[str, Any]
    surveys: tuple[StreamSurvey, ...]
    assembly: LogAssembly

    @property
    def warnings(self) -> list[str]:
        """Return the warnings of the reader that `facts` does not contain."""
        return [text for text in self.assembly.warnings if text not in self.facts["odd"]]


def info(
    log: Log | Path | str, bench: Bench | None = None, window: TimeWindow = EVERYTHING
) -> Information:
    """Survey the contents and the quality of a log; the log is read twice, in bounded memory.

    Parameters
    ----------
    log
        Log in memory, or path of a log file.
    bench
        Bench of the log. A raw log needs a bench, which maps the columns. With a bench, samples at
        the actuator's limit are counted, and the identification methods are tried on a log of at
        most 262 144 samples.
    window
        Time window of the survey.

    Returns
    -------
    Information
        Facts of the log, and the survey of each stream.

    Raises
    ------
    LogError
        If the log cannot be read.
    """
    # sums of values near the largest double may overflow
    with tempfile.TemporaryDirectory() as temporary, np.errstate(over="ignore", invalid="ignore"):
        if isinstance(log, Log):
            path = Path(temporary, Path(log.source).name or "log.mcap")
            write_log(log, path)
        else:
            path = Path(log)
        made, surveys = _surveyed(path, bench, window)
        facts = _facts(made, surveys, bench)
        if bench is not None:
            facts["methods"] = _tried(made, surveys, bench, facts["methods"])
        return Information(facts, tuple(surveys), made)


def _surveyed(
    path: Path, bench: Bench | None, window: TimeWindow
) -> tuple[LogAssembly, list[StreamSurvey]]:
    limits: dict[str, float] = (
        {} if bench is None else {bench.actuator.drive: bench.actuator.limit.value}
    )
    made = assemble([path], bench)
    indices = range(len(start_streams(made, window)))

    def stream(index: int) -> StreamSurvey:
        return survey(
            start_streams(made, window)[index].head,
            lambda: start_streams(made, window)[index].samples,
            limits,
        )

    return made, [stream(index) for index in indices]


def _facts(made: LogAssembly, surveys: list[StreamSurvey], bench: Bench | None) -> dict[str, Any]:
    columns = origins(made, [one.topic for one in surveys]).get(COLUMNS, {})
    main = next((one for one in surveys if "position" in one.signals), surveys[0])
    test, source = _test(made, main)
    sign = sign_of(main.opening)
    velocity = main.velocity
    return {
        "channels": [
            row(seen, one, columns.get(message_path(seen.topic, one.name)))
            for seen in surveys
            for one in seen.signals.values()
        ],
        "duration_s": max(one.base.duration_s for one in surveys),
        "encoder_step": main.signals["position"].step if "position" in main.signals else None,
        "lost": as_rows(made.earlier_losses),
        "test": {"kind": test, "given": source},
        "velocity": None
        if velocity is None
        else {"low": velocity[0], "high": velocity[1], "samples": main.window},
        "work_share": sign.work,
        "reversed": list(sign.reversed),
        "odd": [
            text
            for text in (
                main.jumps.text(),
                sign.text(bench),
                *motion_doubts(main.opening, bench),
                _stream_hint(main, surveys),
            )
            if text
        ],
        "clocks": _clocks(main, surveys),
        "dated_by": {flow.head.topic: flow.clock for flow in made.flows if flow.clock is not None},
        "clock_offset": made.notes.get(CLOCK_OFFSET, {}),
        "layout": made.notes.get(LAYOUT, {}),
        "methods": applicable_methods(
            main, test, known_offset=bench is not None and bench.mechanics.offset is not None
        ),
    }


def _tried(
    made: LogAssembly,
    surveys: list[StreamSurvey],
    bench: Bench,
    reasons: dict[str, str | None],
) -> dict[str, str | None]:
    """Return for each method the reason why the method refuses the log, or None.

    The methods are not tried on a log that is too long; the result is then `reasons`, the verdicts
    without a trial.
    """
    if any(one.opening.time.size < one.base.samples for one in surveys):
        return reasons
    from frictool.identify.method_trials import tried_methods  # loads every method

    log = Log(tuple(one.opening for one in surveys), made.notes, made.flows[0].source)
    return tried_methods(log, bench, reasons)


def _clocks(main: StreamSurvey, surveys: list[StreamSurvey]) -> list[dict[str, Any]]:
    """Return offset and drift of the clock of each further stream against the main stream.

    The clocks are compared by the first signal that both streams contain.
    """
    clocks = []
    for other in surveys:
        common = next(
            (name for name in main.signals if other is not main and name in other.signals), None
        )
        clock = None if common is None else of_streams(main.opening, other.opening, common)
        if clock is not None:
            facts = {"offset_s": clock.offset, "drift": clock.drift, "spread_s": clock.spread}
            clocks.append({"source": other.topic, "against": main.topic, "signal": common, **facts})
    return clocks


def _test(made: LogAssembly, main: StreamSurvey) -> tuple[str | None, bool]:
    """Return the kind of test, and True if this kind was declared to `ingest` (not detected).

    The kind is None if the log has no position or is too short.
    """
    recorded = made.notes.get(KIND, {}).get(TEST)
    return (recorded, True) if recorded else (kind_of(main.opening), False)


def _stream_hint(main: StreamSurvey, surveys: list[StreamSurvey]) -> str | None:
    """Return a hint if position and drive are in different streams, else None."""
    if "position" not in main.signals or any(name in main.signals for name in DRIVES):
        return None
    homes = [
        f"{other.topic} has the {name}"
        for other in surveys
        for name in other.signals
        if name in DRIVES
    ]
    return (
        f"{main.topic} has the position and {homes[0]}: `frictool ingest --resample` puts all "
        "streams on one grid"
        if homes
        else None
    )
