"""Common parts of all commands: options, complete or absent output files, and messages."""

from __future__ import annotations

import math
import os
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

import click

from frictool.cli.file_endings import check_ending
from frictool.cli.output_document_check import check_document
from frictool.cli.printable import printable, printable_json
from frictool.errors import OutputError
from frictool.presentation.json_text import json_text
from frictool.runtime.part_files import part_file

if TYPE_CHECKING:
    from frictool.documents.controller import Controller

F = TypeVar("F", bound=Callable[..., Any])
STDOUT = Path("-")


class NamedPath(click.Path):
    """Path option that rejects an empty name.

    pathlib turns an empty name, for example from an unset shell variable, into the current folder.
    """

    def __init__(
        self, allow_dash: bool = False, writes: Sequence[str] = (), chooses: bool = False
    ) -> None:
        """Store the formats of an output.

        `writes`, `chooses`: as in cli/file_endings.py `check_ending`; without formats any name is
        allowed.
        """
        self._writes, self._chooses = writes, chooses
        # existence and permission are checked on reading, so that the exit code is 3 and not
        # click's 2
        super().__init__(path_type=Path, readable=False, allow_dash=allow_dash)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("the name is empty.", param, ctx)
        path = super().convert(value, param, ctx)
        if self._writes:
            check_ending(Path(str(path)), self._writes, self._chooses)
        return path


def output_option(
    required: bool = True,
    help: str = "Where to write; - is stdout.",
    writes: Sequence[str] = (),
    chooses: bool = False,
) -> Callable[[F], F]:
    """Return the option `-o/--output PATH`; `writes` and `chooses` are as in NamedPath."""
    return click.option(
        "-o", "--output", type=NamedPath(True, writes, chooses), required=required, help=help
    )


allow_undecided_option = click.option(
    "--allow-undecided",
    is_flag=True,
    help=(
        "Exit code 0 also if requirements are undecided, provided that none is broken "
        "and one is met."
    ),
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object on stdout instead of text."
)


def command_line(name: str, arguments: dict[str, Any]) -> str:
    """Return the command for the provenance, in the order of the arguments.

    It contains base names only and no output path.
    """
    words = ["frictool", name]
    for key, value in arguments.items():
        values = value if isinstance(value, list | tuple) else [value]
        for item in values:
            if item is None or item is False:
                continue
            shown = Path(item).name if isinstance(item, Path) else str(item)
            words += (
                [shown] if not key.startswith("--") else [key] if item is True else [key, shown]
            )
    return " ".join(words)


@contextmanager
def replacing(target: Path, inputs: list[Path]) -> Iterator[BinaryIO]:
    """Yield a binary stream that becomes `target` if the block succeeds; else nothing remains.

    `-` is stdout. A device or a pipe is written to and not replaced; for a symbolic link this holds
    for its target file. Raises OutputError if the target is an input, is a directory, or cannot be
    written.
    """
    if target == STDOUT:
        yield sys.stdout.buffer
        sys.stdout.buffer.flush()
        return
    refuse_inputs(target, inputs)
    if target.is_dir():
        raise OutputError(f"{target}: is a directory; name a file")
    if target.exists() and not target.is_file():
        with _device(target) as stream:
            yield stream
        return
    target = target.resolve() if target.is_symlink() else target
    require_folder(target)
    try:
        with part_file(target) as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None


def require_folder(target: Path) -> None:
    """Raise OutputError if the folder of `target` does not exist: its name may be misspelt."""
    folder = target.resolve().parent if target.is_symlink() else target.parent
    if not folder.exists():
        raise OutputError(
            f"{target}: there is no folder {folder}; make it first (mkdir -p "
            f"{shlex.quote(str(folder))}) or name another"
        )
    if not folder.is_dir():
        raise OutputError(f"{target}: cannot be written: {folder} is not a folder")


@contextmanager
def _device(target: Path) -> Iterator[BinaryIO]:
    """Yield a device or a pipe, opened for writing."""
    try:
        with target.open("wb") as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None


def refuse_inputs(target: Path, inputs: list[Path]) -> None:
    """Raise OutputError if writing `target` would overwrite one of `inputs`."""
    for path in inputs:
        if target.exists() and path.exists() and target.samefile(path):
            raise OutputError(
                f"{target}: is an input of this command and would be overwritten; "
                "choose another output"
            )


def check_output(target: Path, inputs: list[Path]) -> None:
    """Raise OutputError if `target` is an input, is a directory, or cannot be written.

    The check creates no file; it precedes long computations.
    """
    refuse_inputs(target, inputs)
    if target == STDOUT or (target.exists() and not target.is_file() and not target.is_dir()):
        return
    if target.is_dir():
        raise OutputError(f"{target}: is a directory; name a file")
    require_folder(target)
    try:
        tempfile.TemporaryFile(dir=target.resolve().parent).close()
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None


def check_targets(targets: Mapping[str, Path | None], inputs: list[Path]) -> None:
    """Check before any work that each target is a separate file and can be written.

    `targets`: option -> path or None. Raises click.UsageError if two targets are equal, and
    OutputError as `check_output`.
    """
    places: dict[Path, str] = {}
    for option, target in targets.items():
        if target is None:
            continue
        place = target if target == STDOUT else target.resolve()
        if place in places and (target == STDOUT or target.is_file() or not target.exists()):
            raise click.UsageError(
                f"{places[place]} and {option} have the same name, {target}; each needs its own."
            )
        places[place] = option
        check_output(target, inputs)


def save_text(target: Path, text: str, inputs: list[Path], draft: bool = False) -> None:
    """Write `text` as UTF-8 to `target`, completely or not at all.

    Stdout gets no control characters. A document is read back first. A draft is not, because it
    contains values to fill in.
    """
    if not draft:
        check_document(target, text)
    with replacing(target, inputs) as stream:
        shown = printable(text) if target == STDOUT else text
        stream.write(
            shown.encode(errors="backslashreplace")
        )  # a file name may contain bytes that are not text


def say(text: str, output: Path | None = None) -> None:
    """Print text on stdout, or on stderr if stdout carries the output."""
    click.echo(printable(text), err=output == STDOUT)


def note(text: str) -> None:
    """Print progress or a warning on stderr."""
    click.echo(printable(text), err=True)


def note_changes(path: Path, controller: Controller) -> None:
    """Warn if a block of a controller changed after its verification.

    A document without digests gives no warning.
    """
    from frictool.documents.digests import changed_words

    if words := changed_words(controller):
        note(f"warning: {path}: {words}")


def use_colour(to_stderr: bool) -> bool:
    """Return True if text may be coloured: on a terminal, unless NO_COLOR is set."""
    return (sys.stderr if to_stderr else sys.stdout).isatty() and not os.environ.get("NO_COLOR")


def print_json(form: str, value: dict[str, Any], output: Path | None = None) -> None:
    """Print a JSON object on stdout, or on stderr if stdout carries the output.

    form: name and version of its format (json_formats.yaml), which its first key says. Values that
    are not finite are null.
    """
    click.echo(printable_json(json_text(form, value)), err=output == STDOUT)


class FiniteRange(click.FloatRange):
    """Range of a number option that rejects NaN and implausible magnitudes.

    click's own range accepts NaN, because every comparison with it is false. A magnitude outside
    LEAST to LARGEST is a typing error, and its square may overflow.
    """

    LEAST, LARGEST = 1e-15, 1e12

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"found {number}; allowed: a finite number.", param, ctx)
        if number and not self.LEAST <= abs(number) <= self.LARGEST:
            self.fail(
                f"found: {number:g}; allowed: 0, or {self.LEAST:g} to {self.LARGEST:g} in size.",
                param,
                ctx,
            )
        return number

    def _describe_range(self) -> str:
        """Return the range for --help; click shows "x<=None" for a range without ends."""
        return "" if self.min is None and self.max is None else super()._describe_range()


existing = NamedPath()
