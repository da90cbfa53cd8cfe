"""`frictool observe run`: velocity, friction and wear in logs, and a verdict on the wear."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import TABLES, is_page
from frictool.cli.observe_request import (
    ObserveRequest,
    check_outputs,
    checked_pattern,
    commissioning_of,
    observer_of,
)
from frictool.cli.output_files import command_line, replacing, save_text
from frictool.cli.progress import note_compiling
from frictool.cli.window_options import window_of, window_options
from frictool.cli.workers_options import refuse_both, workers_options
from frictool.errors import EXIT_DONE, EXIT_INPUT, EXIT_NO
from frictool.runtime import notifications

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance
    from frictool.observe.combined_estimator import EstimateBlock
    from frictool.observe.estimate_plot import EstimatePlot
    from frictool.observe.log_observer import LogObserver
    from frictool.observe.observation_outcome import ObservationOutcome

HELP = """\b
Example:
  frictool observe run model.yaml shift.mcap --wear-limit 1.25 -o estimates.mcap --plot wear.svg
  frictool observe run model.yaml fleet/ --wear-limit 1.25 -o fleet.csv --plot trend.svg

Estimate velocity, friction and wear of a running actuator from its encoder and its drive. Each
estimate has an interval at every sample, and uses earlier samples only. Wear is the dry friction
divided by the model's dry friction; an actuator without wear has the value 1.

LOG is a canonical log, or a raw file with the columns of the model's bench; - is standard input. -o
writes the estimates as a log, --plot draws them.

With a folder or several logs, the result is a table with one row per log: unit, date, wear,
interval, verdict, and the wear divided by the wear in the unit's first log or in --commissioning.
--plot draws the wear over the date. A log that cannot be read has a row with the reason.

Exit codes: 1 if the wear limit is exceeded or a log leaves it undecided; else 3 if a log could not
be read or has lost data; else 0. The outputs are written in every case.
"""


@click.command("run", help=HELP)
@click.argument("model", type=existing, help="Model of the axis (model.yaml).")
@click.argument(
    "logs",
    type=existing,
    nargs=-1,
    required=True,
    metavar="LOG...",
    help="Logs of the running actuator, or folders of logs of a fleet.",
)
@click.option(
    "--wear-limit",
    type=FiniteRange(0.0, min_open=True),
    help=("Exit code 1 if the wear, or the wear relative to the first log, exceeds this limit."),
)
@click.option(
    "--commissioning",
    type=existing,
    help=(
        "First log of the unit, or the --json output of `observe run` for that log; the limit then "
        "applies to the wear relative to that log."
    ),
)
@click.option(
    "--observer",
    type=existing,
    help=("Additional observer (observer.yaml); its estimates are the stream /axis/observer."),
)
@click.option(
    "--plot",
    type=NamedPath(True, ("SVG", "HTML"), True),
    help=(
        "Write a picture (.svg) or a page (.html) of the estimates, or of the trend of several "
        "logs."
    ),
)
@click.option(
    "--confidence",
    type=FiniteRange(0.5, 0.9999),
    default=0.95,
    show_default=True,
    help="Confidence level of the intervals.",
)
@window_options
@click.option("--stream", "topic", metavar="TOPIC", help="Stream of the log. [default: /axis]")
@click.option(
    "--unit",
    metavar="REGEX",
    help=("Pattern of the unit's name in a file name, if the logs do not contain it."),
)
@click.option(
    "--date",
    metavar="REGEX",
    help=("Pattern of the date in a file name: year, month, day, and hour, minute, second."),
)
@click.option(
    "--salvage", is_flag=True, help="Keep the readable part of a damaged file; exit code 3."
)
@workers_options
@output_option(
    required=False,
    help=("Estimates (.mcap), or for several logs the table (.csv, .parquet); - is stdout."),
)
@click.option(
    "--allow-undecided",
    is_flag=True,
    help="Exit code 0 also if a log leaves the wear limit undecided.",
)
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    model: Path,
    logs: tuple[Path, ...],
    confidence: float,
    start: float | None,
    end: float | None,
    topic: str | None,
    unit: str | None,
    date: str | None,
    salvage: bool,
    **kept: Any,
) -> None:
    ctx.with_resource(notifications.receiving(compiling=partial(note_compiling, everywhere=True)))
    from frictool.documents.model import Model
    from frictool.documents.registry import load
    from frictool.logs.fleet import is_fleet
    from frictool.logs.origin import NamePatterns
    from frictool.observe.log_observer import ObservationSettings

    named = {
        "model": model,
        "logs": logs,
        "--wear-limit": kept["wear_limit"],
        "--commissioning": kept["commissioning"],
        "--observer": kept["observer"],
        "--confidence": confidence,
        "--from": start,
        "--to": end,
        "--stream": topic,
        "--unit": unit,
        "--date": date,
        "--salvage": salvage,
    }
    words = command_line("observe run", named)
    patterns = NamePatterns(checked_pattern("--unit", unit), checked_pattern("--date", date))
    settings = ObservationSettings(window_of(start, end), topic, salvage, confidence, patterns)
    request = ObserveRequest(words, model, load(model, Model), settings, **kept)
    refuse_both(request.cores, request.cluster)
    table = request.output is not None and request.output.suffix.lower() in TABLES
    several = is_fleet(logs) or table
    check_outputs(request, logs, several)
    if not several and (request.cores is not None or request.cluster is not None):
        raise click.UsageError("--cores and --cluster need several logs; found: one.")
    if not several:
        ctx.exit(_single(request, logs[0]))
    from frictool.cli.observe_fleet import observe_fleet

    ctx.exit(observe_fleet(request, logs))


def _single(request: ObserveRequest, log: Path) -> int:
    from frictool.cli.progress import progress
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.provenance import provenance_of_command
    from frictool.logs.losses import loss_count_text
    from frictool.logs.origin import LogName, unmatched_patterns
    from frictool.observe.estimate_plot import EstimatePlot
    from frictool.observe.log_observer import LogObserver
    from frictool.observe.observation_outcome import lines, with_verdict

    reference = commissioning_of(request)
    for message in unmatched_patterns(request.settings.patterns, [LogName(log.as_posix())]):
        note(f"warning: {message}")
    with stdin_as_file([log]) as (path,):
        one = LogObserver(path, request.document, request.settings, observer=observer_of(request))
        picture = None if request.plot is None else EstimatePlot(request.document.axis)
        provenance = provenance_of_command(request.words, [*request.inputs, path])
        with progress("observe") as tick:
            _run(request, one, picture, provenance, tick)
        outcome = with_verdict(one.outcome(), request.wear_limit, reference)
    for warning in outcome.warnings:
        note(f"warning: {warning}")
    if picture is not None and request.plot is not None:
        save_text(
            request.plot, _drawn(request, outcome, picture, provenance), [*request.inputs, log]
        )
    if request.as_json:
        print_json("observe-run/1", outcome.as_json(), request.stdout)
    else:
        for line in lines(outcome, request.document):
            say(line, request.stdout)
    if outcome.losses:
        note(
            f"warning: data were lost while reading {Path(outcome.source).name}: "
            f"{loss_count_text(list(outcome.losses))}"
        )
    refused = outcome.verdict is not None and request.answer_is_no(outcome.verdict.exceeded)
    return EXIT_NO if refused else EXIT_INPUT if outcome.losses else EXIT_DONE


def _run(
    request: ObserveRequest,
    one: LogObserver,
    picture: EstimatePlot | None,
    provenance: Provenance,
    tick: Callable[[float], None],
) -> None:
    from frictool.logs.provenance import PROVENANCE, provenance_record
    from frictool.observe.estimates_log import write

    parts = _watched(one, picture, tick)
    if request.output is None:
        for _ in parts:
            pass
        return
    with replacing(request.output, request.inputs) as stream:
        write(one, parts, stream, {PROVENANCE: provenance_record(provenance)})


def _watched(
    one: LogObserver, picture: EstimatePlot | None, tick: Callable[[float], None]
) -> Iterator[EstimateBlock]:
    for part in one.parts():
        tick(one.progress)
        if picture is not None:
            picture.take(part)
        yield part


def _drawn(
    request: ObserveRequest,
    outcome: ObservationOutcome,
    picture: EstimatePlot,
    provenance: Provenance,
) -> str:
    from frictool.observe.page import page_of_log

    drawn = picture.drawn(Path(outcome.source).name, request.wear_limit)
    if request.plot is not None and is_page(request.plot):
        return page_of_log(outcome, request.document, drawn, provenance)
    return drawn + "\n"
