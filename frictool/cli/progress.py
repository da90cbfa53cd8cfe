"""How far a long command is, and what it waits for, on a terminal: a bar on stderr with the time
left. Silent elsewhere."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from frictool.cli.output import note

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


def note_compiling(everywhere: bool = False) -> None:
    """Says once what the first use of a kernel waits for, on a terminal, or `everywhere`: where it
    takes long enough to wonder in a log."""
    if everywhere or sys.stderr.isatty():
        _tell_once()


@functools.cache
def _tell_once() -> None:
    clear = "\r\x1b[K" if sys.stderr.isatty() else ""  # a bar that stands there begins anew below
    click.echo(clear, err=True, nl=False)
    note("compiling for this machine, once per installation (up to a minute) ...")
