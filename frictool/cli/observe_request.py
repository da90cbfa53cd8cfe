"""Options of `frictool observe run`, which are checked before the first log is read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.file_endings import check_ending
from frictool.cli.output_files import STDOUT, check_targets

if TYPE_CHECKING:
    from frictool.documents.model import Model
    from frictool.documents.observer import Observer
    from frictool.observe.commissioning import Commissioning
    from frictool.observe.log_observer import ObservationSettings


@dataclass(frozen=True)
class ObserveRequest:
    """Options of `frictool observe run` with the loaded documents.

    `words`: text of the command, for the provenance.
    """

    words: str
    model: Path
    document: Model
    settings: ObservationSettings
    wear_limit: float | None
    commissioning: Path | None
    observer: Path | None
    plot: Path | None
    output: Path | None
    as_json: bool
    cores: int | None
    cluster: str | None
    allow_undecided: bool

    def answer_is_no(self, exceeded: bool | None) -> bool:
        """Return True if the exit code must be 1.

        The exit code is 1 if the wear exceeds the limit (`exceeded` is True). Without the option
        --allow-undecided, it is also 1 if the verdict is undecided (`exceeded` is None).
        """
        return not self.allow_undecided if exceeded is None else exceeded

    @property
    def inputs(self) -> list[Path]:
        """Return all input files except the logs."""
        return [
            self.model,
            *(path for path in (self.commissioning, self.observer) if path is not None),
        ]

    @property
    def stdout(self) -> Path | None:
        """Return STDOUT if an output is written to stdout, else None."""
        return STDOUT if STDOUT in (self.output, self.plot) else None


def checked_pattern(option: str, text: str | None) -> str | None:
    """Return `text` if it is None or a regular expression; otherwise raise UsageError.

    `option`: name of the option in the message.
    """
    import re

    try:
        re.compile(text or "")
    except re.error as error:
        raise click.UsageError(
            f"{option}: found {text!r}, which is not a regular expression: {error}."
        ) from None
    return text


def check_outputs(request: ObserveRequest, logs: tuple[Path, ...], several: bool) -> None:
    """Check that all outputs can be written; raise UsageError or OutputError if not.

    `several`: True if there are several logs.
    """
    plot, output = request.plot, request.output
    if output is not None:
        check_ending(
            output,
            ("CSV", "Parquet") if several else ("MCAP",),
            several,
            " (several logs give a table)" if several else "",
        )
    if several and request.observer is not None:
        raise click.UsageError("--observer works with one log only.")
    check_targets({"-o": output, "--plot": plot}, [*request.inputs, *logs])


def observer_of(request: ObserveRequest) -> tuple[Path, Observer] | None:
    """Load the observer of --observer; return (path, observer), or None without this option."""
    if request.observer is None:
        return None
    from frictool.documents.observer import Observer
    from frictool.documents.registry import load

    return request.observer, load(request.observer, Observer)


def commissioning_of(request: ObserveRequest) -> Commissioning | None:
    """Return the wear at commissioning from the file of --commissioning; None without this option.

    The file is a log, or the --json output of `observe run`. Raises InputFileError if the JSON
    output contains no wear.
    """
    path = request.commissioning
    if path is None:
        return None
    from frictool.logs.open_file import head_of
    from frictool.observe.commissioning import commissioning_of_estimate, read_commissioning
    from frictool.observe.log_observer import LogObserver

    if head_of(path).lstrip().startswith(b"{"):
        return read_commissioning(path)
    one = LogObserver(path, request.document, request.settings)
    return commissioning_of_estimate(one.wear_alone(), str(path))
