"""How far a long command is, and what it waits for, on a terminal: a bar on stderr with the time left. Silent elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from frictool.cli.output import note

if TYPE_CHECKING:
    from frictool.logs.assembly import Assembly

STEPS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """Gives what is to be told the part that is done, from 0 to 1; it may be told often."""
    if not sys.stderr.isatty():
        yield lambda part: None
        return
    with click.progressbar(length=STEPS, label=label, file=sys.stderr) as bar:

        def told(part: float) -> None:
            steps = min(STEPS, int(part * STEPS)) - bar.pos
            if steps > 0:
                bar.update(steps)

        yield told


def tell_of_compiling(made: Assembly) -> None:
    """Says that the first text file of an installation waits for the compiler."""
    from frictool.logs.table import LAYOUT

    if LAYOUT not in made.notes or not sys.stderr.isatty():
        return
    from frictool.kernels import is_compiled

    if not is_compiled("rows", "read_rows"):
        note("compiling the reader of text, once per installation (about 5 s) ...")
