"""`-` as an input: standard input is kept in a temporary file, as a log is told by its first bytes
and read more than once."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click

from frictool.errors import LogError

STDIN = Path("-")
NAME = "stdin"  # of the file that it becomes, for messages


@contextmanager
def stdin_as_file(paths: Sequence[Path]) -> Iterator[list[Path]]:
    """The paths, standard input as a file that is gone afterwards.

    Raises UsageError where `-` is given twice, LogError where there is no room for it in the folder
    for temporary files (TMPDIR).
    """
    if STDIN not in paths:
        yield list(paths)
        return
    if list(paths).count(STDIN) > 1:
        raise click.UsageError("standard input (-) can be read once only.")
    with tempfile.TemporaryDirectory(prefix="frictool-") as folder:
        file = Path(folder, NAME)
        try:
            with file.open("wb") as stream:
                shutil.copyfileobj(sys.stdin.buffer, stream, 1 << 20)
        except OSError as error:
            raise LogError(
                NAME,
                f"cannot be kept in {folder}: {error.strerror or error}; set TMPDIR to a folder with room",
            ) from None
        yield [file if path == STDIN else path for path in paths]
