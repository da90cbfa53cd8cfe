"""Opening an input file, and telling by its first bytes what it is."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO, Literal

from frictool.errors import LogError

Format = Literal["mcap", "mat", "hdf5", "text"]
HEAD_BYTES = 4096


def open_log(path: Path) -> BinaryIO:
    """The file, open for reading. Raises LogError where it is missing, a directory, no regular file, not permitted, or empty."""
    try:
        if path.is_dir():
            raise LogError(path, "is a directory; a log file is expected")
        if not path.exists():
            raise LogError(path, "no such file")
        if not path.is_file():
            raise LogError(path, "is not a regular file; a log file is expected")
        if path.stat().st_size == 0:
            raise LogError(path, "is empty; a log file is expected")
        return path.open("rb")
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL character
        raise LogError(path, f"cannot be read: {getattr(error, 'strerror', None) or error}") from None


def format_of(path: Path) -> Format:
    """What the file holds, by its content and never by its name.

    Raises LogError where it cannot be read or is none of the formats.
    """
    with open_log(path) as stream:
        try:
            head = stream.read(HEAD_BYTES)
        except OSError as error:
            raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    if head.startswith(b"\x89MCAP"):
        return "mcap"
    if b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:520]):
        return "hdf5"
    if head[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return "mat"
    if b"\0" in head:
        raise LogError(path, "is binary and no known format; allowed: MCAP, MATLAB v5, text with columns (CSV)")
    return "text"
