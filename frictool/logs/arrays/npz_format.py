"""Reader of NumPy files (`.npy` and `.npz`); pickled objects are not loaded.

A column of the table is a vector, a column of a matrix, or a field of a structured array. A matrix
with more columns than rows is divided into its rows instead. The first vector of dates
(`datetime64`) gives the times of the rows.
"""

from __future__ import annotations

import math
import warnings
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

import numpy as np
from numpy.lib import format as npy

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.array_table import ArrayColumn, ArrayTable
from frictool.logs.arrays.byte_streams import ArchiveBytes, ByteStream, FileBytes
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import RawTable

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

NPY, ZIP = b"\x93NUMPY", b"PK\x03\x04"
ALONE = "array"  # name of the array in a .npy file, which stores no name
MOST_MEMBERS = 20_000
MOST_COLUMNS = 1000  # longest shorter side of a matrix
LONGEST_HEAD = 1 << 16  # bytes, maximum size of an array's header
LONGEST_REASON = 50  # maximum characters of zipfile's error text, which may quote whole members
HEADS = {
    (1, 0): npy.read_array_header_1_0,
    (2, 0): npy.read_array_header_2_0,
    (3, 0): npy.read_array_header_2_0,
}


@dataclass(frozen=True)
class NpyArray:
    """Array in a `.npy` or `.npz` file, as the header of the array describes it.

    open: function that returns a stream of the header and the numbers.
    start: offset of the first number in that stream, in bytes.
    by_columns: True if the numbers are stored column by column (Fortran order).
    """

    name: str
    open: Callable[[], ByteStream]
    start: int
    shape: tuple[int, ...]
    by_columns: bool
    dtype: np.dtype[Any]

    def __str__(self) -> str:
        kind = (
            "objects"
            if self.dtype.hasobject
            else "structures"
            if self.dtype.names
            else str(self.dtype)
        )
        return f"{'x'.join(map(str, self.shape)) or 'single'} {kind}"

    def columns(self) -> Iterator[tuple[str, ArrayColumn]]:
        """Yield the name and the location of each vector in the array."""
        sides = [n for n in self.shape if n != 1]
        if self.dtype.hasobject or math.prod(self.shape) < 2:
            return
        if len(sides) == 1:
            yield from self._fields()
        elif len(self.shape) == 2 and min(self.shape) <= MOST_COLUMNS and not self.dtype.names:
            high, wide = self.shape
            # distance to the next row and to the next column, in numbers
            to_row, to_column = (1, high) if self.by_columns else (wide, 1)
            for k in range(min(self.shape)):
                if high >= wide:
                    yield f"{self.name}[:, {k}]", self._line(k * to_column, high, to_row)
                else:
                    yield f"{self.name}[{k}, :]", self._line(k * to_row, wide, to_column)

    def _line(self, first: int, rows: int, stride: int) -> ArrayColumn:
        size = self.dtype.itemsize
        return ArrayColumn(self.open, self.start + first * size, self.dtype, rows, stride * size)

    def _fields(self) -> Iterator[tuple[str, ArrayColumn]]:
        rows = math.prod(self.shape)
        if self.dtype.names is None or self.dtype.fields is None:
            yield (
                self.name,
                ArrayColumn(self.open, self.start, self.dtype, rows, self.dtype.itemsize),
            )
            return
        for name in self.dtype.names:
            dtype, offset = self.dtype.fields[name][:2]
            if dtype.shape == () and dtype.names is None:
                key = name if self.name == ALONE else f"{self.name}.{name}"
                yield (
                    key,
                    ArrayColumn(self.open, self.start + offset, dtype, rows, self.dtype.itemsize),
                )


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file is a NumPy array, or a zip archive that begins with an array."""
    return head.startswith(NPY) or (
        head.startswith(ZIP)
        and head[30 : 30 + int.from_bytes(head[26:28], "little")].endswith(b".npy")
    )


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return one table of all vectors of real numbers in the file.

    Raises LogError if the file has no such vector, or if the directory of the archive cannot be
    read.
    """
    with open_log(path) as stream:
        is_array = stream.read(len(NPY)) == NPY
    size = path.stat().st_size
    damage: list[str] = []
    members = list(
        _member(ALONE, partial(FileBytes, path, 0, size), size, damage)
        if is_array
        else _members(path, damage)
    )
    vectors = {name: column for member in members for name, column in member.columns()}
    columns = {name: column for name, column in vectors.items() if column.dtype.kind in "iufb"}
    others = {member.name: str(member) for member in members if member.name not in columns}
    clock, dated = next(
        ((name, column) for name, column in vectors.items() if column.dtype.kind == "M"),
        (None, None),
    )
    if not columns and damage:
        raise LogError(path, f"is damaged: {damage[0]}")
    if not columns:
        raise LogError(
            path,
            "has no vector of real numbers; found: "
            f"{listed([f'{name} ({text})' for name, text in others.items()])}",
        )
    return (
        ArrayTable(
            str(path), columns, size, others, damage[0] if damage else None, dated, clock=clock
        ),
    )


def _members(path: Path, damage: list[str]) -> Iterator[NpyArray]:
    try:
        with zipfile.ZipFile(path) as archive:
            arrays = [one for one in archive.infolist() if one.filename.endswith(".npy")]
    except Exception as error:
        # on a damaged directory zipfile also raises errors of struct, codecs and others
        raise LogError(
            path,
            f"is not a complete zip archive ({error}); the file may be cut off: copy it again",
        ) from None
    if len(arrays) > MOST_MEMBERS:
        raise LogError(path, f"contains {len(arrays)} arrays; allowed: at most {MOST_MEMBERS}")
    for one in arrays:
        yield from _member(
            one.filename.removesuffix(".npy"), partial(_inside, path, one), one.file_size, damage
        )


def _inside(path: Path, member: zipfile.ZipInfo) -> ByteStream:
    """Open an array in the archive; on failure, return an empty stream that states the reason."""
    try:
        with zipfile.ZipFile(path) as archive:
            return ArchiveBytes(archive.open(member), member.file_size)
    except Exception as error:  # zipfile raises errors of many types
        stream = FileBytes(path, 0, 0)
        stream.damage = f"cannot be opened in its archive ({str(error)[:LONGEST_REASON]})"
        return stream


def _member(
    name: str, opened: Callable[[], ByteStream], size: int, damage: list[str]
) -> Iterator[NpyArray]:
    with opened() as stream, warnings.catch_warnings():
        file = cast(IO[bytes], stream)
        warnings.simplefilter("ignore")  # warnings about Python 2's long integers and type aliases
        try:
            shape, by_columns, dtype = HEADS[npy.read_magic(file)](
                file, max_header_size=LONGEST_HEAD
            )
        except Exception as error:  # a damaged head or type raises errors of many types
            damage.append(
                f"array {name!r} "
                f"{stream.damage or f'has a damaged head ({str(error) or type(error).__name__})'}"
            )
            return
        start = stream.position
    content = dtype.itemsize * math.prod(shape)
    if min(shape, default=0) < 0 or dtype.itemsize == 0:
        damage.append(f"array {name!r} has a damaged head (its shape is {shape})")
        return
    if content != size - start and not dtype.hasobject:
        damage.append(
            f"array {name!r} declares {content} bytes of numbers, but {size - start} follow"
        )
    yield NpyArray(name, opened, start, shape, by_columns, dtype)
