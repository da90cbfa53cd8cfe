"""Options `--from` and `--to`: time window of a log, in the log's own time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from frictool.cli.common_options import FiniteRange

if TYPE_CHECKING:
    from frictool.logs.log_assembly import TimeWindow

F = TypeVar("F", bound=Callable[..., Any])


def window_options(function: F) -> F:
    """Add `--from` and `--to` to a command, as parameters `start` and `end` [s] or None."""
    end = click.option(
        "--to",
        "end",
        type=FiniteRange(),
        metavar="S",
        help="Leave out samples after this time of the log [s].",
    )
    start = click.option(
        "--from",
        "start",
        type=FiniteRange(),
        metavar="S",
        help="Leave out samples before this time of the log [s].",
    )
    return start(end(function))


def window_of(start: float | None, end: float | None) -> TimeWindow:
    """Return the time window; raise UsageError if the window is empty or a time exceeds LATEST."""
    from frictool.logs.canonical.mcap_layout import LATEST
    from frictool.logs.log_assembly import TimeWindow

    for key, at in (("--from", start), ("--to", end)):
        if at is not None and abs(at) > LATEST:
            raise click.UsageError(f"{key}: found {at:g}; allowed: at most {LATEST:g} s.")
    if start is not None and end is not None and start > end:
        raise click.UsageError(f"--from {start:g} is after --to {end:g}.")
    return TimeWindow.between(start, end)
