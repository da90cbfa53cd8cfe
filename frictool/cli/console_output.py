"""Text, warnings and JSON objects that commands print on stdout and stderr."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output_files import STDOUT
from frictool.cli.terminal_escapes import printable, printable_json
from frictool.presentation.json_text import json_text

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model


class Verbosity:
    """Amount of text on stderr besides warnings and errors, the same for the whole process.

    - quiet: no progress and no remarks
    - verbose: progress also if stderr is not a terminal
    """

    quiet = False
    verbose = False


def shows_progress() -> bool:
    """Return True if progress is printed: on a terminal, or with --verbose; never with --quiet."""
    return not Verbosity.quiet and (Verbosity.verbose or sys.stderr.isatty())


def say(text: str, output: Path | None = None) -> None:
    """Print text on stdout, or on stderr if the output file `output` is stdout."""
    click.echo(printable(text), err=output == STDOUT)


def note(text: str) -> None:
    """Print progress or a warning on stderr."""
    click.echo(printable(text), err=True)


def note_temperature(path: Path, model: Model, vertices: bool = False) -> None:
    """Warn that a command uses one temperature, if the model's friction depends on temperature.

    vertices: True if the command designs a controller for the vertices of the model.
    """
    from frictool.adapters.temperature_factors import reference_words

    law = None if model.laws is None else model.laws.temperature
    if law is not None and (text := reference_words(law, vertices)):
        note(f"warning: {path}: {text}; let the ranges in bench.yaml include these values")


def note_missing_effects(path: Path, model: Model) -> None:
    """Warn of effects that the logs of a model show, but that the model lacks."""
    from frictool.documents.missing_effects import missing_effects

    for text in missing_effects(model):
        note(f"warning: {path}: {text}")


def note_travel(path: Path, bench: Bench) -> None:
    """Warn that a test may reach an end stop, if the bench states no travel."""
    if bench.mechanics.travel is None:
        unless = ", unless the axis turns without end" if bench.axis == "rotary" else ""
        note(
            f"warning: {path}: mechanics.travel is missing, so that the test may reach an end "
            f"stop; add it{unless}"
        )


def note_changes(path: Path, controller: Controller) -> None:
    """Warn if a block of the controller was changed after the controller was verified.

    A change is recognised by the digests in the document; without digests there is no warning.
    """
    from frictool.documents.digests import changed_words

    if words := changed_words(controller):
        note(f"warning: {path}: {words}")


def use_colour(to_stderr: bool) -> bool:
    """Return True if text may be coloured: on a terminal, unless NO_COLOR is set."""
    return (sys.stderr if to_stderr else sys.stdout).isatty() and not os.environ.get("NO_COLOR")


def print_json(form: str, value: dict[str, Any], output: Path | None = None) -> None:
    """Print a JSON object on stdout, or on stderr if the output file `output` is stdout.

    form: name and version of the format (json_formats.yaml), written into the object's first key.
    Values that are not finite become null.
    """
    click.echo(printable_json(json_text(form, value)), err=output == STDOUT)
