"""`frictool ingest`: conversion of raw log files to the canonical log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from frictool.cli.common_options import FiniteRange, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import check_ending
from frictool.cli.guessed_columns import preset_text, question_lines
from frictool.cli.layout_option import layout_advice, layout_of, layout_option
from frictool.cli.output_files import STDOUT, command_line, replacing, save_text
from frictool.cli.window_options import window_of, window_options
from frictool.errors import FrictoolError
from frictool.logs.quality.log_kinds import KINDS

if TYPE_CHECKING:
    from frictool.documents.bench import Layout
    from frictool.logs.ingestion import IngestedLog
    from frictool.logs.log_assembly import LogAssembly

HELP = """\b
Example:
  frictool ingest sines.csv --bench bench.yaml -o sines.mcap

Convert bench files to the canonical log (MCAP), which Foxglove, PlotJuggler and ROS 2 tools open.

RAW is a file of any format that frictool reads; its content determines the format. `columns` of the
bench assigns columns to channels, and everything is converted to SI. A canonical log needs no
conversion. The first file becomes the stream /axis; each further file of the same rig becomes a
stream /axis/NAME.

--from and --to keep the part of the log between two times. --resample joins all streams to one
stream /axis with a constant period: commands, drives and efforts keep their last value, other
signals are interpolated linearly, and nothing is extrapolated. There is no filter: do not resample
fast signals to a longer period. --salvage keeps the readable part of a damaged file and lists the
losses; the exit code is then 3.
"""


@click.command("ingest", help=HELP)
@click.argument(
    "raw",
    type=existing,
    nargs=-1,
    required=True,
    help="Bench files of any format that frictool reads, or canonical logs; - is standard input.",
)
@click.option(
    "--bench",
    type=existing,
    help="Rig with the columns (bench.yaml); not needed for a canonical log.",
)
@click.option(
    "--guess",
    is_flag=True,
    help=(
        "Instead of a log, write a bench.yaml that is guessed from the names and units of RAW; "
        "check it."
    ),
)
@click.option(
    "--axis",
    type=click.Choice(["rotary", "linear"]),
    help="With --guess: kind of axis. [default: from units or names]",
)
@layout_option
@window_options
@click.option(
    "--resample",
    "period",
    type=FiniteRange(1e-6, 10.0),
    metavar="S",
    help="Put all streams on one grid of this period [s].",
)
@click.option(
    "--kind",
    type=click.Choice(list(KINDS)),
    help="Kind of test in the log. [default: as info recognises it]",
)
@click.option(
    "--unit",
    "unit_name",
    metavar="NAME",
    help="Serial number of the actuator, by which `observe run` groups logs.",
)
@click.option(
    "--date",
    metavar="DATE",
    help="Date of the recording (2026-01-03 or 2026-01-03T08:15:00), if the log contains no date.",
)
@click.option(
    "--salvage", is_flag=True, help="Keep the readable part of a damaged file; exit code 3."
)
@output_option()
@json_option
def command(
    raw: tuple[Path, ...],
    bench: Path | None,
    guess: bool,
    axis: Literal["rotary", "linear"] | None,
    layout_texts: tuple[str, ...],
    start: float | None,
    end: float | None,
    period: float | None,
    kind: str | None,
    unit_name: str | None,
    date: str | None,
    salvage: bool,
    output: Path,
    as_json: bool,
) -> None:
    from frictool.cli.progress import progress
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.bench import Bench
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load

    named = {"--kind": kind, "--unit": unit_name, "--date": date}
    options = {"--from": start, "--to": end, "--resample": period, **named, "--salvage": salvage}
    of_guess = {"--axis": axis, "--layout": layout_texts or None}
    _check_guess(guess, of_guess, {"--bench": bench, **options})
    check_ending(output, ("YAML",) if guess else ("MCAP",), chooses=False)
    if guess:
        _propose(raw, axis, layout_of(layout_texts), output, as_json)
        return
    document = None if bench is None else load(bench, Bench)
    from frictool.logs.canonical.mcap_reader import is_canonical
    from frictool.logs.ingestion import IngestRequest, write_assembly
    from frictool.logs.log_assembly import assemble
    from frictool.logs.raw_table import LAYOUT
    from frictool.logs.recordings.recording_files import sources
    from frictool.logs.text.text_layout import PLAIN

    request = IngestRequest(window_of(start, end), period, kind, unit_name, date, salvage)
    try:
        request.check()
    except FrictoolError as wrong:
        raise click.UsageError(f"--{wrong}.") from None
    line = command_line("ingest", {"raw": raw, "--bench": bench, **options})
    with stdin_as_file(raw) as paths:
        recordings = sources(paths)
        if bench is None and not all(
            len(parts) == 1 and is_canonical(parts[0]) for parts in recordings
        ):
            raise click.UsageError(
                "Missing option '--bench'; without a bench.yaml, use --guess, which proposes one."
            )
        inputs = [
            *(file for parts in recordings for file in parts),
            *([] if bench is None else [bench]),
        ]
        made = assemble(paths, document, salvage)
        provenance = provenance_of_command(line, inputs)
        with replacing(output, inputs) as stream, progress("ingest") as tick:
            ingested = write_assembly(made, stream, request, provenance, tick)
    for parts in recordings:
        if len(parts) > 1:
            note(f"{', '.join(part.name for part in parts)}: read as parts of one recording")
    for name, layout in made.notes.get(LAYOUT, {}).items():
        if layout != PLAIN:
            note(f"{name}: {layout}")
    for warning in made.warnings:
        note(f"warning: {warning}")
    facts = summary(ingested)
    if as_json:
        print_json("ingest/1", facts, output)
    else:
        say(table(facts), output)
    _refuse_loss(made, output)


def _check_guess(guess: bool, of_guess: dict[str, Any], others: dict[str, Any]) -> None:
    """Raise UsageError for an option without effect: `others` with --guess, `of_guess` without."""
    wrong = [name for name, value in others.items() if value is not None and value is not False]
    if guess and wrong:
        raise click.UsageError(f"--guess writes a bench.yaml and no log: leave out {wrong[0]}.")
    for name, value in of_guess.items():
        if value is not None and not guess:
            raise click.UsageError(
                f"{name} belongs to --guess; without --guess, the bench states the "
                f"{name.removeprefix('--')}."
            )


def _propose(
    raw: tuple[Path, ...],
    axis: Literal["rotary", "linear"] | None,
    layout: Layout | None,
    output: Path,
    as_json: bool,
) -> None:
    """Write a bench.yaml whose columns are guessed from a file.

    No log is converted with this bench.yaml, because the user must check it first.
    """
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.starting_documents import starting_documents
    from frictool.logs.channels.column_guess import start_from

    if len(raw) > 1:
        raise click.UsageError(
            "--guess takes one log; write the columns of further instruments into the section "
            "`instruments` of bench.yaml by hand."
        )
    with stdin_as_file(raw) as (path,), layout_advice():
        start = start_from(path, path.stem[:80] or "rig", axis, layout=layout)
    save_text(
        output, starting_documents(start)["bench.yaml"], list(raw), draft=bool(start.questions)
    )
    if as_json:
        facts = {
            "axis": start.axis,
            "columns": start.columns,
            "left": start.left,
            "unreadable": start.unreadable,
            "preset": start.preset,
            "sample_period_s": start.period,
        }
        print_json("ingest-guess/1", {**facts, "questions": start.questions}, output)
        return
    guesses = (
        ", ".join(
            f"{channel} is {column!r} [{unit}]" for channel, (column, unit) in start.columns.items()
        )
        or "no channel"
    )
    say(
        (
            f"guessed from {start.log}{preset_text(start)}: {guesses}; check the values marked "
            "as guessed, and replace those marked as examples"
        ),
        output,
    )
    for line in question_lines(start):
        say(line, output)


def _refuse_loss(made: LogAssembly, output: Path) -> None:
    from frictool.errors import LogError
    from frictool.logs.losses import loss_count_text

    if made.losses:
        where = "the output" if output == STDOUT else output.name
        raise LogError(
            made.flows[0].source,
            (
                f"data were lost while reading: {loss_count_text(made.losses)}; {where} "
                "contains the readable data and lists the losses"
            ),
        )


def summary(ingested: IngestedLog) -> dict[str, Any]:
    """Return a summary of the streams of the converted log as JSON values."""
    from frictool.logs.losses import as_rows

    made = ingested.assembly
    clocks = {flow.head.topic: flow.clock for flow in made.flows}
    rows = [
        {
            "topic": head.topic,
            "channels": dict(zip(head.fields, head.units, strict=True)),
            "samples": base.samples,
            "rate_hz": base.rate_hz,
            "duration_s": base.duration_s,
            "gaps": base.gaps,
            "clock": clocks.get(head.topic),
        }
        for head, base in ingested.streams
    ]
    return {"streams": rows, "warnings": list(made.warnings), "lost": as_rows(made.losses)}


def table(facts: dict[str, Any]) -> str:
    """Return the summary `facts` as text."""
    from frictool.logs.losses import loss_lines
    from frictool.logs.raw_table import DataLoss

    lines = []
    for stream in facts["streams"]:
        channels = ", ".join(f"{name} [{unit}]" for name, unit in stream["channels"].items())
        lines.append(f"{stream['topic']}: {channels}")
        rate = f"{stream['rate_hz']:.6g} Hz" if stream["samples"] > 1 else "one sample"
        dated = f", dated by {stream['clock']}" if stream["clock"] else ""
        gaps = f"{stream['gaps']} gap{'s' * (stream['gaps'] != 1)}"
        lines.append(
            f"  {stream['samples']} samples, {rate}, {stream['duration_s']:.6g} s, {gaps}{dated}"
        )
    lines += [f"lost: {text}" for text in loss_lines([DataLoss(**row) for row in facts["lost"]])]
    return "\n".join(lines)
