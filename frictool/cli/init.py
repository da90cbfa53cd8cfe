"""`frictool init`: commented documents to start a rig's folder from."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.output import existing, json_option, note, print_json, say

if TYPE_CHECKING:
    from frictool.documents.starter import Start

HELP = """\b
Example:
  frictool init my_rig --from bench.csv
  make -C my_rig

Write a rig's documents to start from, commented: bench.yaml, spec.yaml, designs/speed.yaml, scenarios/steps.yaml, and a Makefile that
chains the commands by file dependencies into build/.

With --from, what a log (CSV with a header, MATLAB, MCAP of ingest) tells by itself is filled in and marked as guessed: columns, units,
sample period, the encoder's step where positions are no counts. Everything else is an example that loads: set it.
Nothing that exists is overwritten.
"""


@click.command("init", help=HELP)
@click.argument("folder", metavar="DIR", type=existing)
@click.option("--axis", type=click.Choice(["rotary", "linear"]), help="Kind of axis; else by the log's units, else rotary.")
@click.option("--from", "log", type=existing, metavar="LOG", help="A log of the bench to guess from.")
@json_option
def command(folder: Path, axis: str | None, log: Path | None, as_json: bool) -> None:
    from frictool.cli.folder import save_folder
    from frictool.documents.starter import starting_documents

    start = _start(folder, axis, log)
    files = starting_documents(start)
    save_folder(folder, files, [] if log is None else [log], overwrite=False)
    if log is not None and start.log_path is None:
        note(f"warning: make cannot read the path of {log.name}, it has blanks or signs of its own; the Makefile takes what lies in logs/")
    if as_json:
        guessed = {"axis": start.axis, "columns": start.columns, "left": start.left, "sample_period_s": start.period}
        print_json({"folder": str(folder), "files": list(files), "log": start.log, **guessed, "encoder_step": start.step})
        return
    say(f"{folder}: {', '.join(files)}")
    if log is not None:
        found = ", ".join(f"{channel} is {column!r} [{unit}]" for channel, (column, unit) in start.columns.items()) or "no channel"
        say(f"guessed from {log.name}: {found}; check what is marked as guessed, set what is marked as an example")


def _start(folder: Path, axis: str | None, log: Path | None) -> Start:
    """What the rig starts from: the folder's name, and what the log tells."""
    from frictool.documents.starter import Start

    name = folder.absolute().name[:80] or "rig"
    if log is None:
        return Start(name, "linear" if axis == "linear" else "rotary")
    from frictool.logs.guess import guess_from

    guess = guess_from(log, None if axis is None else "linear" if axis == "linear" else "rotary")
    path = os.path.relpath(log.absolute(), folder.absolute())
    return Start(
        name=name,
        axis=guess.axis,
        log=log.name,
        log_path=path if re.fullmatch(r"[\w./+,@-]+", path) else None,
        drive=guess.drive,
        columns=guess.columns,
        left=guess.left,
        period=guess.period,
        step=guess.step,
    )
