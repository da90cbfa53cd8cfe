"""Opening of input files."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from frictool.errors import LogError

HEAD_BYTES = 4096


def open_log(path: Path) -> BinaryIO:
    """Return the file, open for reading.

    Raises LogError if the path is missing, empty, a directory, not a regular file, or not readable.
    """
    try:
        if path.is_dir():
            raise LogError(path, "is a directory; a log file is expected")
        if not path.exists():
            raise LogError(path, "no such file")
        if not path.is_file():
            raise LogError(
                path,
                "is not a regular file; a log file is expected (to read a pipe, use `frictool "
                "ingest -`)",
            )
        if path.stat().st_size == 0:
            raise LogError(path, "is empty; a log file is expected")
        return path.open("rb")
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL character
        raise LogError(
            path, f"cannot be read: {getattr(error, 'strerror', None) or error}"
        ) from None


def head_of(path: Path) -> bytes:
    """Return the first HEAD_BYTES bytes of the file; raise LogError if it cannot be read."""
    with open_log(path) as stream:
        try:
            return stream.read(HEAD_BYTES)
        except OSError as error:
            raise LogError(path, f"cannot be read: {error.strerror or error}") from None
