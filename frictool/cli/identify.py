"""`frictool identify`: parameters with intervals from logs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import check_ending
from frictool.cli.observe_request import checked_pattern
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.workers_options import refuse_both, workers_options
from frictool.identify.methods import DEFAULT, METHODS, OPTIONS

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.documents.model import Model
    from frictool.identify.identification import Identification
    from frictool.identify.methods import IdentificationRequest

METHOD_LINES = "\n".join(
    f"  {name:<16} {method.what}\n{'':<19}for {method.when}" for name, method in METHODS.items()
)
HELP = f"""\b
Example:
  frictool identify sines.mcap ramp.mcap --bench bench.yaml -o model.yaml

Identify the friction model  effort = inertia a + viscous v + coulomb sign(v) + offset  and the
breakaway at rest, each with an interval.

Logs are canonical logs, or raw files with the columns of the bench. Logs of motion determine the
sliding parameters (all but the breakaway). Breakaway ramps determine the breakaway: the effort
grows until the axis moves, falls back, and grows again. Such logs are recognised, or named with
--ramp. Slow loops of the effort below the breakaway (--loops) determine the presliding laws.

\b
Methods (--method), and suitable data:
{METHOD_LINES}

A parameter that the logs do not determine is listed with the reason, and the model contains the
bench's interval for it. Intervals apply to the bench's nominal effort constant; an error of the
constant scales inertia and all friction parameters by the same factor.

\b
Many actuators, or many records of one actuator:
  frictool identify --each log fleet/ --bench bench.yaml --date '\\d{{4}}-\\d\\d-\\d\\d' -o models/

Each log (or with --each folder, each folder of logs) gives one model in the folder of -o, and one
row of parameters.csv there. With -o FILE.csv or FILE.parquet only the table is written. The scatter
of the parameters is compared with their intervals, to find actuators that differ and parameters
that drift. A log that cannot be used has a row with the reason.

Exit codes: 1 if the logs are in order but no fit is possible; 4 if a fit gives neither inertia nor
friction, or if position and drive have opposite signs. In these cases no model is written. With
--keep-bench-values, a model with the bench's values is written instead, and the exit code is 0; the
model is marked, and synth refuses it. With --each: 4 if any log gives 4, else 1 if any log gives 1,
else 3 if a log cannot be used.
"""


def _method_options(command: Callable[..., None]) -> Callable[..., None]:
    for option in reversed(OPTIONS):
        number: click.IntRange | FiniteRange = (
            click.IntRange(int(option.low), None if option.high is None else int(option.high))
            if option.kind is int
            else FiniteRange(option.low, option.high, min_open=option.low_open)
        )
        default = "" if option.default is None else f" [default: {option.default}]"
        text = f"{option.readers}: {option.what}{', odd' * option.odd}.{default}"
        command = click.option(option.flag, type=number, help=text)(command)
    return command


@click.command("identify", help=HELP)
@click.argument(
    "logs",
    type=existing,
    nargs=-1,
    metavar="LOG...",
    help="Logs of motion or breakaway ramps, canonical or raw. With --each also folders of logs.",
)
@click.option("--bench", type=existing, required=True, help="Rig (bench.yaml).")
@click.option(
    "--ramp",
    type=existing,
    multiple=True,
    help="Log of breakaway ramps, even if it is recognised as another kind; repeatable.",
)
@click.option(
    "--breakaway-table",
    type=existing,
    help=(
        "CSV of single breakaways, in place of ramps: effort [N m | N] and rate of the ramp (any "
        "unit), as columns with these names or in this order."
    ),
)
@click.option(
    "--loops",
    type=existing,
    multiple=True,
    help=("Log of slow loops below the breakaway, from a rest without elastic force; repeatable."),
)
@click.option(
    "--measurement",
    is_flag=True,
    help=(
        "Also identify properties of the bench: backlash, drive delay, current-loop time constant."
    ),
)
@click.option(
    "--method",
    type=click.Choice(list(METHODS)),
    default=DEFAULT,
    show_default=True,
    help="Method for the sliding parameters.",
)
@click.option(
    "--confidence",
    type=FiniteRange(0.5, 0.9999),
    default=0.95,
    show_default=True,
    help="Confidence level of every interval.",
)
@_method_options
@click.option(
    "--keep-bench-values",
    is_flag=True,
    help=("Write a marked model of the bench's values even if nothing was identified."),
)
@click.option(
    "--each",
    type=click.Choice(["log", "folder"]),
    help="Identify a model for each log, or for the logs of each folder.",
)
@click.option(
    "--unit",
    metavar="REGEX",
    help=("With --each: pattern of the unit's name in a file name, if the logs do not contain it."),
)
@click.option(
    "--date",
    metavar="REGEX",
    help=(
        "With --each: pattern of the date in a file name: year, month, day, and hour, "
        "minute, second."
    ),
)
@workers_options
@click.option(
    "--promise",
    type=existing,
    help="File of `frictool excite --promise`: compare the intervals with the promised intervals.",
)
@click.option(
    "--plot",
    type=NamedPath(writes=("SVG",)),
    help="Write only the figures of the page, one below the other (SVG).",
)
@click.option(
    "--page",
    type=NamedPath(writes=("HTML",)),
    help=(
        "Write a page of the model: friction, residual, held-out strokes, intervals, models that "
        "were compared, and what to measure next (HTML)."
    ),
)
@output_option(required=False, help="Model (YAML); - is stdout. Without it nothing is written.")
@json_option
def command(
    logs: tuple[Path, ...],
    bench: Path,
    ramp: tuple[Path, ...],
    breakaway_table: Path | None,
    loops: tuple[Path, ...],
    measurement: bool,
    method: str,
    confidence: float,
    keep_bench_values: bool,
    each: str | None,
    unit: str | None,
    date: str | None,
    cores: int | None,
    cluster: str | None,
    promise: Path | None,
    plot: Path | None,
    page: Path | None,
    output: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    if not (logs or ramp or loops):
        raise click.UsageError("Missing argument 'LOG...'.")
    _check_options(method, options)
    alone = {
        "--ramp": ramp,
        "--breakaway-table": breakaway_table,
        "--loops": loops,
        "--promise": promise,
        "--plot": plot,
        "--page": page,
        "--keep-bench-values": keep_bench_values or None,
    }
    _check_each(
        each, alone, {"--unit": unit, "--date": date, "--cores": cores, "--cluster": cluster}
    )
    refuse_both(cores, cluster)
    if breakaway_table is not None and ramp:
        raise click.UsageError(
            "--ramp and --breakaway-table both determine the breakaway; leave out one of them."
        )
    tables = [one for one in (promise, breakaway_table) if one is not None]
    inputs = [*logs, *ramp, *loops, bench, *tables]
    if each is None:
        if output is not None:
            check_ending(output, ("YAML",), chooses=False)
        check_targets({"-o": output, "--plot": plot, "--page": page}, inputs)
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load
    from frictool.identify.methods import IdentificationRequest, IdentificationSettings

    document = load(bench, Bench)
    settings = IdentificationSettings.of_options(confidence, options)
    table = None
    if breakaway_table is not None:
        from frictool.identify.breakaway.rate_table import read_rate_table

        table = read_rate_table(breakaway_table)
    request = IdentificationRequest(method, settings, measurement, keep_bench_values, table)
    shown: dict[str, Any] = {
        "--breakaway-table": breakaway_table,
        "--measurement": measurement,
        "--method": method,
        "--confidence": confidence,
        **{one.flag: options[one.name] for one in OPTIONS},
        "--keep-bench-values": keep_bench_values,
    }
    if each is None:
        views = IdentifyViews(plot, page, promise, as_json)
        _alone(IdentifyCommand(logs, ramp, loops, bench, document, request, shown, output, views))
        return
    from frictool.cli.identify_each import IdentifyEachCommand, identify_each
    from frictool.logs.origin import NamePatterns

    patterns = NamePatterns(checked_pattern("--unit", unit), checked_pattern("--date", date))
    line = IdentifyEachCommand(
        each, bench, document, request, patterns, shown, output, as_json, cores, cluster
    )
    click.get_current_context().exit(identify_each(line, logs))


@dataclass(frozen=True)
class IdentifyViews:
    """Requested views of a model: figure, page, comparison with `promise.yaml`, and JSON."""

    plot: Path | None
    page: Path | None
    promise: Path | None
    as_json: bool


@dataclass(frozen=True)
class IdentifyCommand:
    """Arguments and options of `frictool identify` for one model, and the loaded bench.

    `shown`: name and value of the options that affect the model, for the provenance.
    """

    logs: tuple[Path, ...]
    ramp: tuple[Path, ...]
    loops: tuple[Path, ...]
    bench: Path
    document: Bench
    request: IdentificationRequest
    shown: dict[str, Any]
    output: Path | None
    views: IdentifyViews


def _alone(line: IdentifyCommand) -> None:
    from frictool.documents.promise import Promise
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.writing import to_yaml
    from frictool.identify.from_logs import identify
    from frictool.identify.identification import NothingIdentified
    from frictool.logs.log_reader import read_log

    breakaways = line.request.breakaway_table
    inputs = [*line.logs, *line.ramp, *line.loops, line.bench]
    inputs += [] if breakaways is None else [Path(breakaways.name)]
    document = line.document
    output = line.output
    views = line.views
    promise = None if views.promise is None else load(views.promise, Promise)
    shown = {
        "logs": line.logs,
        "--bench": line.bench,
        "--ramp": line.ramp,
        "--loops": line.loops,
        **line.shown,
    }
    read, ramps, slow = (
        [read_log(path, document) for path in paths] for paths in (line.logs, line.ramp, line.loops)
    )
    try:
        outcome = identify(
            read,
            document,
            line.request,
            ramps=ramps,
            loops=slow,
            provenance=provenance_of_command(command_line("identify", shown), inputs),
            tell=lambda warning: note(f"warning: {warning}"),
        )
    except NothingIdentified as error:
        _show(error.result, document, views.as_json, output)
        if len(error.reasons) > 1:
            for reason, names in error.reasons.items():
                note(f"not identified: {', '.join(names)}: {reason}")
        raise
    promised = None
    if promise is not None:
        from frictool.identify.promise_comparison import compare_with_promise

        promised = compare_with_promise(outcome, document, promise)
    if output is not None:
        save_text(output, to_yaml(outcome.model), inputs)
    if views.plot is not None or views.page is not None:
        from frictool.identify.model_page.page import model_page, model_panels, model_picture

        panels = model_panels(outcome, line.request)
        if views.plot is not None:
            save_text(views.plot, model_picture(outcome, panels) + "\n", inputs)
        if views.page is not None:
            save_text(views.page, model_page(outcome, panels), inputs)
    extra = {} if promised is None else {"promise": [row.view() for row in promised]}
    _show(outcome.result, document, views.as_json, output, outcome.model, extra)
    if not views.as_json:
        from frictool.identify.text_view import table

        say("\n".join([table(outcome), *(row.line() for row in promised or ())]), output)


def _show(
    result: Identification,
    bench: Bench,
    as_json: bool,
    output: Path | None,
    model: Model | None = None,
    extra: Mapping[str, Any] | None = None,
) -> None:
    for warning in result.warnings:
        note(f"warning: {warning}")
    if model is not None and model.bench_values_only is not None:
        note(
            "warning: the model contains only the bench's values, since nothing was identified; "
            "synth refuses it"
        )
    if as_json:
        from frictool.identify.json_view import as_view

        print_json("identify/1", as_view(result, bench, model) | dict(extra or {}), output)


def _check_options(method: str, values: dict[str, Any]) -> None:
    for option in OPTIONS:
        value = values[option.name]
        if value is not None and option.name not in METHODS[method].reads:
            raise click.UsageError(
                f"{option.flag} belongs to --method {option.readers}, not to {method}."
            )
        if option.odd and value is not None and value % 2 == 0:
            raise click.BadParameter(
                f"{value} is even; allowed: an odd number.", param_hint=f"'{option.flag}'"
            )


def _check_each(each: str | None, alone: dict[str, Any], many: dict[str, Any]) -> None:
    wrong = [
        name for name, value in (many if each is None else alone).items() if value not in (None, ())
    ]
    if wrong and each is None:
        raise click.UsageError(f"{wrong[0]} belongs to --each; add --each, or leave it out.")
    if wrong:
        raise click.UsageError(
            f"{wrong[0]} does not work with --each, which recognises ramps itself."
        )
