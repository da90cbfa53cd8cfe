"""Standard input in place of an input file (`-`), copied to a temporary file.

The copy is needed because a log is read more than once.
"""

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
NAME = "stdin"  # name of the temporary file in messages


@contextmanager
def stdin_as_file(paths: Sequence[Path]) -> Iterator[list[Path]]:
    """Yield `paths` with `-` replaced by a temporary file that contains the standard input.

    Raises UsageError if `-` occurs twice, and LogError if the folder for temporary files (TMPDIR)
    is too small.
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
                f"cannot be kept in {folder}: {error.strerror or error}; set TMPDIR to a folder "
                "with more space",
            ) from None
        yield [file if path == STDIN else path for path in paths]
