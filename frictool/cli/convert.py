"""`frictool convert`: conversion of a log to the formats of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import STDOUT, command_line, replacing
from frictool.logs.channels.question import alternatives
from frictool.logs.formats import WRITTEN, format_for, require

if TYPE_CHECKING:
    from frictool.logs.conversion import OutgoingStream

HELP = f"""\b
Example:
  frictool convert run.mcap -o run.mat

Convert a log to {alternatives([one.written for one in WRITTEN.values()])}. The ending of OUTPUT, or
--to, selects the format.

Times are in s and signals in SI, with their units. The numbers in OUTPUT and LOG are equal bit for
bit. A raw bench file needs --bench. A file of
{alternatives([name for name, one in WRITTEN.items() if one.several])} has all streams of LOG. A
file of any other format contains one stream; select it with --stream if LOG has several.
"""


@click.command("convert", help=HELP)
@click.argument("log", type=existing, help="Canonical log, or raw bench file with --bench.")
@click.option(
    "--bench",
    type=existing,
    help=("Rig whose columns describe LOG, if LOG is a raw bench file (bench.yaml)."),
)
@click.option(
    "--to",
    "kind",
    type=click.Choice([*WRITTEN]),
    help="Format, if the output's name does not determine it.",
)
@click.option(
    "--stream",
    "topics",
    multiple=True,
    metavar="TOPIC",
    help="Convert this stream only, /axis or /axis/NAME; repeatable.",
)
@output_option()
@json_option
def command(
    log: Path,
    bench: Path | None,
    kind: str | None,
    topics: tuple[str, ...],
    output: Path,
    as_json: bool,
) -> None:
    from frictool.documents.bench import Bench
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.logs.conversion import OutgoingStream, convert
    from frictool.logs.log_assembly import assemble, origins, start_streams
    from frictool.logs.losses import LOST, loss_count_text, record_of
    from frictool.logs.provenance import PROVENANCE, provenance_record

    form = WRITTEN[kind] if kind else format_for(output)
    if form is None:
        endings = alternatives([one.suffixes[0] for one in WRITTEN.values()])
        raise click.UsageError(
            f"{output.name!r} does not determine the format; let the name end in {endings}"
            ", or give --to."
        )
    require(form, output)
    document = None if bench is None else load(bench, Bench)
    inputs = [log] if bench is None else [log, bench]
    made = assemble([log], document)
    chosen = _chosen(
        str(log), [OutgoingStream(one.head, one.samples) for one in start_streams(made)], topics
    )
    line = command_line(
        "convert", {"log": log, "--bench": bench, "--to": form.name, "--stream": list(topics)}
    )
    notes = {
        **made.notes,
        **origins(made, [one.head.topic for one in chosen]),
        PROVENANCE: provenance_record(provenance_of_command(line, inputs)),
    }
    if made.earlier_losses:
        notes[LOST] = record_of(made.earlier_losses)
        note(
            f"warning: data were lost when {log.name} was made: "
            f"{loss_count_text(made.earlier_losses)}; `frictool info` lists them"
        )
    with replacing(output, inputs) as stream:
        convert(str(log), chosen, notes, form, stream)
    for warning in made.warnings:
        note(f"warning: {warning}")
    facts = {
        "file_format": form.name,
        "streams": {
            one.head.topic: dict(zip(one.head.fields, one.head.units, strict=True))
            for one in chosen
        },
    }
    if as_json:
        print_json("convert/1", facts, output)
    else:
        where = "stdout" if output == STDOUT else output.name
        say(f"{where}: {form.name}, {', '.join(one.head.topic for one in chosen)}", output)


def _chosen(
    source: str, streams: list[OutgoingStream], topics: tuple[str, ...]
) -> list[OutgoingStream]:
    from frictool.logs.raw_table import pick

    names = [one.head.topic for one in streams]
    wanted = [pick(names, topic, source, "stream") for topic in topics] or names
    return [one for one in streams if one.head.topic in wanted]
