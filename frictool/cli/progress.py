"""How far a long command is, and what it waits for, on a terminal: a bar on stderr with the time left. Silent elsewhere."""

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


@functools.cache
def tell_of_compiling() -> None:
    """Says once what the first use of a kernel waits for; a bar that stands there begins anew below."""
    if sys.stderr.isatty():
        note("\r\x1b[Kcompiling for this machine, once per installation (up to a minute) ...")
