"""Reader of MATLAB files of version 4 to 7.

Each real vector and each column of a real matrix becomes a column of the table. The name of a
vector in a structure is its path, such as `data.signals.values`. Version 7.3 is another file format
(mat73_format.py).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays import mat4_elements, mat_elements, mat_objects
from frictool.logs.arrays.array_table import ArrayTable
from frictool.logs.arrays.mat_array import MatArray, described
from frictool.logs.arrays.reader_process import open_guarded
from frictool.logs.open_file import HEAD_BYTES, open_log
from frictool.logs.raw_table import RawTable

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

VERSION_5 = (b"\x00\x01IM", b"\x01\x00MI")


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file has the signature of versions 5 to 7 or looks like version 4."""
    return head[124:128] in VERSION_5 or mat4_elements.looks_like(head)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table of all vectors of the file, then each MATLAB table and timetable.

    All vectors that a log uses must have the same length. Raises LogError if the file has neither a
    vector nor a readable MATLAB table. Damage inside a vector is reported when the vector is read.
    """
    with open_log(path) as stream:
        head = stream.read(HEAD_BYTES)
    size = path.stat().st_size
    arrays: list[MatArray] = []
    damage: str | None = None
    try:
        is_new = head[124:128] in VERSION_5
        arrays.extend((mat_elements if is_new else mat4_elements).arrays(path, size))
    except ValueError as error:
        damage = str(error)
    except OSError as error:
        raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    # arrays without a name are the bytes of MATLAB's objects
    named = [array for array in arrays if array.name]
    objects = (
        open_guarded(path, mat_objects.open_objects)
        if len(named) < len(arrays) and mat_objects.can_read()
        else ()
    )
    arrays = named
    columns = {name: column for array in arrays for name, column in array.columns()}
    if not columns and damage is not None:
        raise LogError(path, f"is damaged or not a MATLAB file: {damage}")
    if not columns and objects:
        return objects
    if not columns:
        raise LogError(
            path,
            "has no real numeric vector; found: "
            f"{listed([f'{array.name} ({array})' for array in arrays])}",
        )
    return (ArrayTable(str(path), columns, size, described(arrays), damage), *objects)
