"""Progress of long commands on a terminal: a bar on stderr with the remaining time."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from frictool.cli.console_output import note

STEPS = 1000


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """Yield a callback that takes the completed fraction (0 to 1); frequent calls are cheap.

    It prints nothing if stderr is not a terminal.
    """
    if not sys.stderr.isatty():
        yield lambda part: None
        return
    with click.progressbar(length=STEPS, label=label, file=sys.stderr) as bar:

        def show(part: float) -> None:
            steps = min(STEPS, int(part * STEPS)) - bar.pos
            if steps > 0:
                bar.update(steps)

        yield show


def note_step(step: str) -> None:
    """Print the step that begins, on a terminal only."""
    if sys.stderr.isatty():
        note(f"{step} ...")


def search_progress() -> Callable[[str], None]:
    """Return a callback that prints each step of a search on stderr.

    Without a terminal it leaves out the first step, so that a quick search prints nothing.
    """
    printed = sys.stderr.isatty()

    def show(step: str) -> None:
        nonlocal printed
        if printed:
            note(f"{step} ...")
        printed = True

    return show


def show_count(verb: str, done: int, total: int) -> None:
    """Print `VERB 3 of 17` on a terminal, overwriting the line; nothing if there is one only."""
    if total > 1 and sys.stderr.isatty():
        end = "\n" if done == total else ""
        click.echo(f"\r{verb} {done} of {total}{end}", err=True, nl=False)


def note_compiling(everywhere: bool = False) -> None:
    """Print once that a kernel is being compiled, on a terminal or with `everywhere` on any stderr.

    `everywhere` is for compilations that take long enough to puzzle the reader of a log.
    """
    if everywhere or sys.stderr.isatty():
        _note_once()


@functools.cache
def _note_once() -> None:
    # clears the present bar, which is drawn again below
    clear = "\r\x1b[K" if sys.stderr.isatty() else ""
    click.echo(clear, err=True, nl=False)
    note("compiling for this machine, once per installation (up to a minute) ...")
