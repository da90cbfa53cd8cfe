"""MATLAB files of version 4 to 7: each real vector is a column, each matrix one of its columns at a
time, structures by their path.

Version 7.3 is another format altogether (mat73_format.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.errors import LogError
from frictool.logs.arrays import mat4_elements, mat_elements
from frictool.logs.arrays.array_table import ArrayTable
from frictool.logs.arrays.mat_array import MatArray, described
from frictool.logs.open_file import HEAD_BYTES, open_log
from frictool.logs.table import RawTable, listed

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

VERSION_5 = (b"\x00\x01IM", b"\x01\x00MI")


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is one of version 5 to 7, by its signature, or looks like one of version 4,
    which has none."""
    return head[124:128] in VERSION_5 or mat4_elements.looks_like(head)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """The one table of the file: all its vectors, of which those have to be of one length that are
    asked for together.

    Raises LogError where there is none; what else is damaged is told by `blocks`.
    """
    with open_log(path) as stream:
        head = stream.read(HEAD_BYTES)
    size = path.stat().st_size
    found: list[MatArray] = []
    damage: str | None = None
    try:
        _gather(
            mat_elements.arrays(path, size)
            if head[124:128] in VERSION_5
            else mat4_elements.arrays(path, size),
            found,
        )
    except ValueError as error:
        damage = str(error)
    except OSError as error:
        raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    found = [
        array for array in found if array.name
    ]  # without a name are the bytes of MATLAB's objects
    columns = {name: column for array in found for name, column in array.columns()}
    if not columns and damage is not None:
        raise LogError(path, f"is damaged or no MATLAB file: {damage}")
    if not columns:
        raise LogError(
            path,
            f"has no real numeric vector; found: {listed([f'{array.name} ({array})' for array in found])}",
        )
    return (ArrayTable(str(path), columns, size, described(found), damage),)


def _gather(arrays: Iterator[MatArray], found: list[MatArray]) -> None:
    """Appends the arrays as far as they can be read."""
    found.extend(arrays)
