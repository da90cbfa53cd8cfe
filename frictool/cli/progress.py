"""Progress of long commands: a bar on stderr with the remaining time, on a terminal only."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from frictool.cli.console_output import Verbosity, note, shows_progress


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """Yield a callback that takes the completed fraction (0 to 1); frequent calls are cheap.

    The bar appears on a terminal only; without a terminal, --verbose shows the label.
    """
    if not shows_progress():
        yield lambda part: None
        return
    if not sys.stderr.isatty():
        note_step(label)
        yield lambda part: None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn()
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bars:
        task = bars.add_task(escape(label), total=1.0)
        yield lambda part: bars.update(task, completed=min(max(part, 0.0), 1.0))


def note_step(step: str) -> None:
    """Print the name of the step that begins, if progress is shown."""
    if shows_progress():
        note(f"{step} ...")


def search_progress() -> Callable[[str], None]:
    """Return a function that prints each step of a search on stderr.

    If stderr is not a terminal, the first step is not printed, so that a quick search prints
    nothing.
    """
    printed = shows_progress()

    def show(step: str) -> None:
        nonlocal printed
        if printed and not Verbosity.quiet:
            note(f"{step} ...")
        printed = True

    return show


def show_count(verb: str, done: int, total: int) -> None:
    """Print `VERB 3 of 17` in place of the last such line on a terminal.

    Nothing is printed if `total` is 1.
    """
    if total > 1 and shows_progress() and sys.stderr.isatty():
        end = "\n" if done == total else ""
        click.echo(f"\r{verb} {done} of {total}{end}", err=True, nl=False)


def note_compiling(everywhere: bool = False) -> None:
    """Print once, on a terminal, that kernels are being compiled.

    `everywhere`: True to print also if stderr is not a terminal, because the compilation takes
    long.
    """
    if shows_progress() or (everywhere and not Verbosity.quiet):
        _note_once()


@functools.cache
def _note_once() -> None:
    # clears the present bar, which is drawn again below
    clear = "\r\x1b[K" if sys.stderr.isatty() else ""
    click.echo(clear, err=True, nl=False)
    note("compiling for this machine, once per installation (up to a minute) ...")
