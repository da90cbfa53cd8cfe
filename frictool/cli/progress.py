"""How far a long command is, on a terminal: a bar on stderr with the time left. Silent elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

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
