"""`frictool init`: commented starting documents in the folder of a new rig."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.guessed_columns import preset_text, question_lines
from frictool.cli.layout_option import layout_advice, layout_of, layout_option
from frictool.documents.example_rigs import EXAMPLES
from frictool.presentation.line_breaking import bounded

if TYPE_CHECKING:
    from frictool.documents.bench import Layout
    from frictool.documents.quantity import Axis
    from frictool.documents.starting_documents import StartingRig

LONGEST_TEXT = 120  # characters of a line with keys

_EXAMPLES = "\n".join(f"  {name:<7} {text}" for name, text in EXAMPLES.items())
HELP = f"""\b
Example:
  frictool init my_rig --from bench.csv --axis rotary
  make -C my_rig
  frictool init clutch --example clutch && make -C clutch

Write commented documents for a new rig: bench.yaml, spec.yaml, designs/automatic.yaml,
scenarios/steps.yaml, and a Makefile that runs the commands and writes to build/.

With --from, properties that a log shows are filled in and marked as guessed: columns, units, sample
period, and the encoder's step if the positions are not counts. A unit, column or scale that the log
does not show is written as "?" with the candidates in a comment; other commands refuse the bench
until you fill it in. If the log does not show the kind of axis, --axis is needed. Without --from,
put the bench's logs into DIR/logs/ before you run make.

\b
--example writes a worked rig with its logs, which needs no changes:
{_EXAMPLES}

All other values of a new rig are examples, marked "# example: replace"; the command lists their
keys. A verdict that depends on examples says nothing about your rig. Existing files are not
overwritten.
"""


@click.command("init", help=HELP)
@click.argument("folder", metavar="DIR", type=existing, help="Folder to write the documents to.")
@click.option(
    "--axis",
    type=click.Choice(["rotary", "linear"]),
    help="Kind of axis. [default: from units or names of the log]",
)
@click.option(
    "--from",
    "log",
    type=existing,
    metavar="LOG",
    help="Log of the bench from which properties are guessed.",
)
@layout_option
@click.option(
    "--example", type=click.Choice(list(EXAMPLES)), help="Worked rig to write, with its logs."
)
@json_option
def command(
    folder: Path,
    axis: str | None,
    log: Path | None,
    layout_texts: tuple[str, ...],
    example: str | None,
    as_json: bool,
) -> None:
    from frictool.cli.output_folder import save_folder

    if layout_texts and log is None:
        raise click.UsageError("--layout belongs to --from LOG, and states the layout of the log.")
    if example is not None:
        if axis is not None or log is not None:
            raise click.UsageError("--example does not work with --axis or --from.")
        _write_example(folder, example, as_json)
        return
    from frictool.documents.starting_documents import example_keys, starting_documents

    start = _start(folder, axis, log, layout_of(layout_texts))
    files = starting_documents(start)
    save_folder(folder, files, [] if log is None else [log], overwrite=False, parents=True)
    if log is not None and start.log_path is None:
        note(
            f"warning: make cannot read the path of {log.name} because of its blanks or "
            "special characters; the Makefile uses the files in logs/"
        )
    if as_json:
        guessed = {
            "axis": start.axis,
            "columns": start.columns,
            "left": start.left,
            "unreadable": start.unreadable,
            "preset": start.preset,
            "sample_period_s": start.period,
        }
        view = {
            "log": start.log,
            **guessed,
            "questions": start.questions,
            "encoder_step": start.step,
            "examples": example_keys(start),
        }
        print_json("init/1", {"folder": str(folder), "files": list(files), **view})
        return
    say(f"{folder}: {', '.join(files)}")
    if log is not None:
        guesses = (
            ", ".join(
                f"{channel} is {column!r} [{unit}]"
                for channel, (column, unit) in start.columns.items()
            )
            or "no channel"
        )
        say(
            f"guessed from {log.name}{preset_text(start)}: {guesses}; check the values marked "
            "as guessed"
        )
        for line in question_lines(start):
            say(line)
    say(_still_to_do(folder, start, example_keys(start)))


def _write_example(folder: Path, example: str, as_json: bool) -> None:
    from frictool.cli.output_folder import save_folder
    from frictool.documents.example_rigs import example_files

    files = example_files(example)
    save_folder(folder, files, [], overwrite=False, parents=True)
    if as_json:
        print_json("init-example/1", {"folder": str(folder), "example": example, "files": [*files]})
        return
    say(f"{folder}: {', '.join(files)}")
    say(f"next: make -C {shlex.quote(str(folder))}")


def _still_to_do(folder: Path, start: StartingRig, keys: dict[str, list[str]]) -> str:
    lines = ["these values are examples; replace them before you rely on a verdict"]
    lines += [f"  {name}: {', '.join(messages)}" for name, messages in keys.items()]
    text = bounded(lines, LONGEST_TEXT)
    if start.log_path is None:
        text += (
            f"\nput the bench's logs (CSV, MATLAB, MCAP) into {folder / 'logs'}/, then "
            f"run make -C {shlex.quote(str(folder))}"
        )
    return text


def _start(folder: Path, axis: str | None, log: Path | None, layout: Layout | None) -> StartingRig:
    from frictool.documents.starting_documents import StartingRig

    name = folder.absolute().name[:80] or "rig"
    if log is None:
        return StartingRig(
            name,
            "linear" if axis == "linear" else "rotary",
            axis_source="example" if axis is None else "given",
        )
    from frictool.logs.channels.column_guess import start_from

    path = os.path.relpath(log.absolute(), folder.absolute())
    requested: Axis | None = None if axis is None else "linear" if axis == "linear" else "rotary"
    log_path = path if re.fullmatch(r"[\w./+,@-]+", path) else None
    with layout_advice():
        return start_from(log, name, requested, log_path, layout)
