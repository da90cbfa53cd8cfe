"""NumPy's `.npy` and `.npz`: vectors, the columns of matrices and the fields of structured arrays;
nothing is unpickled.

The first vector of dates (`datetime64`) is the clock of the rows.
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

from frictool.errors import LogError
from frictool.logs.arrays.array_table import ArrayColumn, ArrayTable
from frictool.logs.arrays.byte_streams import ArchiveBytes, ByteStream, FileBytes
from frictool.logs.open_file import open_log
from frictool.logs.table import RawTable, listed

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

NPY, ZIP = b"\x93NUMPY", b"PK\x03\x04"
ALONE = "array"  # what the one array of an .npy is called
MOST_MEMBERS = 20_000
MOST_COLUMNS = 1000  # of a matrix
LONGEST_HEAD = 1 << 16
LONGEST_REASON = 80  # characters: zipfile quotes whole members
HEADS = {
    (1, 0): npy.read_array_header_1_0,
    (2, 0): npy.read_array_header_2_0,
    (3, 0): npy.read_array_header_2_0,
}


@dataclass(frozen=True)
class NpyArray:
    """An array: how to open its bytes, where in them its numbers begin, and what its head says of
    them."""

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
        """The vectors in it, by the name that asks for them."""
        sides = [n for n in self.shape if n != 1]
        if self.dtype.hasobject or math.prod(self.shape) < 2:
            return
        if len(sides) == 1:
            yield from self._fields()
        elif len(self.shape) == 2 and min(self.shape) <= MOST_COLUMNS and not self.dtype.names:
            high, wide = self.shape
            to_row, to_column = (
                (1, high) if self.by_columns else (wide, 1)
            )  # numbers from one to the next
            for k in range(min(self.shape)):
                if high >= wide:
                    yield f"{self.name}[:, {k}]", self._line(k * to_column, high, to_row)
                else:
                    yield f"{self.name}[{k}, :]", self._line(k * to_row, wide, to_column)

    def _line(self, first: int, rows: int, stride: int) -> ArrayColumn:
        size = self.dtype.itemsize
        return ArrayColumn(self.open, self.start + first * size, self.dtype, rows, stride * size)

    def _fields(self) -> Iterator[tuple[str, ArrayColumn]]:
        """A vector itself, or the fields of a structured one."""
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
    """Whether the file is an array, or a zip archive whose first member is one."""
    return head.startswith(NPY) or (
        head.startswith(ZIP)
        and head[30 : 30 + int.from_bytes(head[26:28], "little")].endswith(b".npy")
    )


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """The one table of the file. Raises LogError where it holds no vector, or its archive has no
    readable directory."""
    with open_log(path) as stream:
        is_array = stream.read(len(NPY)) == NPY
    size = path.stat().st_size
    damage: list[str] = []
    found = list(
        _member(ALONE, partial(FileBytes, path, 0, size), size, damage)
        if is_array
        else _members(path, damage)
    )
    vectors = {name: column for member in found for name, column in member.columns()}
    columns = {name: column for name, column in vectors.items() if column.dtype.kind in "iufb"}
    others = {member.name: str(member) for member in found if member.name not in columns}
    clock, dated = next(
        ((name, column) for name, column in vectors.items() if column.dtype.kind == "M"),
        (None, None),
    )
    if not columns and damage:
        raise LogError(path, f"is damaged: {damage[0]}")
    if not columns:
        raise LogError(
            path,
            f"has no vector of real numbers; found: {listed([f'{name} ({text})' for name, text in others.items()])}",
        )
    return (
        ArrayTable(
            str(path), columns, size, others, damage[0] if damage else None, dated, clock=clock
        ),
    )


def _members(path: Path, damage: list[str]) -> Iterator[NpyArray]:
    """The arrays of an archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            found = [one for one in archive.infolist() if one.filename.endswith(".npy")]
    except Exception as error:
        # beside BadZipFile, zipfile raises what struct, codecs and others do on a damaged directory
        raise LogError(
            path,
            f"is no whole zip archive ({error}); its directory is at its end: is the file cut off?",
        ) from None
    if len(found) > MOST_MEMBERS:
        raise LogError(path, f"holds {len(found)} arrays; allowed: {MOST_MEMBERS}")
    for one in found:
        yield from _member(
            one.filename.removesuffix(".npy"), partial(_inside, path, one), one.file_size, damage
        )


def _inside(path: Path, member: zipfile.ZipInfo) -> ByteStream:
    """The bytes of one array of an archive, which closes with it."""
    try:
        with zipfile.ZipFile(path) as archive:
            return ArchiveBytes(archive.open(member), member.file_size)
    except Exception as error:  # as above, and RuntimeError where it is encrypted
        stream = FileBytes(path, 0, 0)
        stream.damage = f"cannot be opened in its archive ({str(error)[:LONGEST_REASON]})"
        return stream


def _member(
    name: str, opened: Callable[[], ByteStream], size: int, damage: list[str]
) -> Iterator[NpyArray]:
    """The array of `size` bytes, head and all, that are opened so; nothing where its head cannot be
    read."""
    with opened() as stream, warnings.catch_warnings():
        file = cast(IO[bytes], stream)
        warnings.simplefilter("ignore")  # of Python 2's long integers, of aliases of types
        try:
            shape, by_columns, dtype = HEADS[npy.read_magic(file)](
                file, max_header_size=LONGEST_HEAD
            )
        except Exception as error:  # whatever evaluating a damaged head and its type raises
            damage.append(
                f"array {name!r} {stream.damage or f'has a damaged head ({str(error) or type(error).__name__})'}"
            )
            return
        start = stream.position
    content = dtype.itemsize * math.prod(shape)
    if min(shape, default=0) < 0 or dtype.itemsize == 0:
        damage.append(f"array {name!r} has a damaged head (its shape is {shape})")
        return
    if content != size - start and not dtype.hasobject:
        damage.append(
            f"array {name!r} announces {content} bytes of numbers, {size - start} are there"
        )
    yield NpyArray(name, opened, start, shape, by_columns, dtype)
