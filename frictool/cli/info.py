"""`frictool info`: contents and data quality of a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option, output_option
from frictool.cli.console_output import note, print_json
from frictool.cli.layout_option import layout_advice, layout_of, layout_option
from frictool.cli.output_files import STDOUT, save_text
from frictool.cli.window_options import window_of, window_options

if TYPE_CHECKING:
    from frictool.documents.bench import Layout
    from frictool.logs.log import Log

HELP = """\b
Example:
  frictool info sines.mcap

Show the contents and the quality of a log: channels, sample rate and jitter, gaps, resolution of
the encoder and of every other signal, velocities, saturation, signals that keep a value for several
samples, the kind of test, the sign of the effort relative to the motion, lost data, and the
identification methods that suit the log.

With --bench, a raw bench file is shown in SI, samples at the actuator's limit are counted, and the
identification methods are tried on a log of at most 262 144 samples.
Without --bench, columns with a known name and unit are shown in the units of the file, from its
first 262 144 rows. Properties that the file does not determine are listed.
"""


@click.command("info", help=HELP)
@click.argument(
    "log", type=existing, help="Log of any format that frictool reads; - is standard input."
)
@click.option(
    "--bench",
    type=existing,
    help=("Rig whose columns describe LOG, if LOG is a raw bench file (bench.yaml)."),
)
@layout_option
@window_options
@output_option(required=False, writes=("text", "Markdown"))
@json_option
def command(
    log: Path,
    bench: Path | None,
    layout_texts: tuple[str, ...],
    start: float | None,
    end: float | None,
    output: Path | None,
    as_json: bool,
) -> None:
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load
    from frictool.identify.info import info
    from frictool.identify.info.text_view import table

    if layout_texts and bench is not None:
        raise click.UsageError("--layout does not work with --bench, which has its own layout.")
    document = None if bench is None else load(bench, Bench)
    window = window_of(start, end)
    with stdin_as_file([log]) as (path,):
        raw = _guessed(path, layout_of(layout_texts)) if bench is None else None
        information = info(path if raw is None else raw, document, window)
    for warning in information.warnings:
        note(f"warning: {warning}")
    if as_json:
        print_json("info/1", information.facts, output)
    if output is not None or not as_json:
        save_text(
            output or STDOUT, table(information) + "\n", [log] if bench is None else [log, bench]
        )


def _guessed(path: Path, layout: Layout | None) -> Log | None:
    from frictool.documents.bench import OPEN
    from frictool.logs.canonical.mcap_reader import is_canonical
    from frictool.logs.channels.guessed_log import guess_log

    if is_canonical(path):
        return None
    with layout_advice():
        guess = guess_log(path, layout)
    columns = ", ".join(
        f"{channel} is {column!r} [{unit}]"
        for channel, (column, unit) in guess.guess.columns.items()
        if column != OPEN
    )
    preset = f" with the preset {guess.guess.preset}" if guess.guess.preset else ""
    note(f"guessed without --bench{preset}: {columns}; nothing is converted")
    for question in guess.guess.questions:
        note(f"columns.{question.channel}: {question.key} unknown: {question.why}")
    return guess.log
