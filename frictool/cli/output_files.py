"""Output files of commands: each appears completely or not at all, and no input is overwritten."""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import click

from frictool.cli.output_document_check import check_document
from frictool.cli.terminal_escapes import printable
from frictool.errors import OutputError
from frictool.runtime.part_files import part_file

STDOUT = Path("-")


def command_line(name: str, arguments: dict[str, Any]) -> str:
    """Return the text of a command for the provenance, with options in the order of `arguments`.

    Paths are shortened to base names. Arguments that are None or False are left out.
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
    """Yield a binary stream whose content replaces `target` if the `with` block succeeds.

    If the block fails, `target` stays as it was. `-` is stdout. A device or a pipe is written to
    and not replaced. If `target` is a symbolic link, the file it points to is replaced. Raises
    OutputError if `target` is an input, is a directory, or cannot be written.
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
    """Raise OutputError if the folder of `target` does not exist."""
    folder = target.resolve().parent if target.is_symlink() else target.parent
    if not folder.exists():
        raise OutputError(
            f"{target}: there is no folder {folder}; create it (mkdir -p "
            f"{shlex.quote(str(folder))}) or name another folder"
        )
    if not folder.is_dir():
        raise OutputError(f"{target}: cannot be written: {folder} is not a folder")


@contextmanager
def _device(target: Path) -> Iterator[BinaryIO]:
    try:
        with target.open("wb") as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None


def refuse_inputs(target: Path, inputs: list[Path]) -> None:
    """Raise OutputError if `target` is one of the files `inputs`, which would be overwritten."""
    for path in inputs:
        if target.exists() and path.exists() and target.samefile(path):
            raise OutputError(
                f"{target}: is an input of this command and would be overwritten; "
                "choose another output"
            )


def check_output(target: Path, inputs: list[Path]) -> None:
    """Raise OutputError if `target` is an input, is a directory, or cannot be written.

    The check creates no file; commands call it before long computations.
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
    """Check, before any work, that all outputs differ and that each of them can be written.

    `targets`: path of each output option, or None. Raises click.UsageError if two paths are equal,
    and OutputError under the conditions of `check_output`.
    """
    options: dict[Path, str] = {}
    for option, target in targets.items():
        if target is None:
            continue
        path = target if target == STDOUT else target.resolve()
        if path in options and (target == STDOUT or target.is_file() or not target.exists()):
            raise click.UsageError(
                f"{options[path]} and {option} have the same name, {target}; give two names."
            )
        options[path] = option
        check_output(target, inputs)


def save_text(target: Path, text: str, inputs: list[Path], draft: bool = False) -> None:
    """Write `text` as UTF-8 to `target`, completely or not at all.

    On stdout, control characters are escaped. A document is checked first, unless it is a draft
    with values to fill in.
    """
    if not draft:
        check_document(target, text)
    with replacing(target, inputs) as stream:
        shown = printable(text) if target == STDOUT else text
        stream.write(
            shown.encode(errors="backslashreplace")
        )  # a file name may contain bytes that are not text
