"""Reader of MATLAB files of version 7.3 and other HDF5 files, with h5py (extra `mat73`).

Columns are named as in mat_format.py: `data.signals.values(:,2)`, `runs(2).x`, `cells{1}`. Links to
other files are not followed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays import mat_objects
from frictool.logs.arrays.array_table import check_rows
from frictool.logs.arrays.mat_array import ADVICE, lines
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import BLOCK_ROWS, DataLoss, RawTable, RowBlock, common_rows
from frictool.typing import Vector

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

SIGNATURE = b"\x89HDF\r\n\x1a\n"
HEADS = (0, 512, 1024, 2048)  # possible offsets of the signature; MATLAB writes 512 bytes before it
CLASS, OBJECT, EMPTY = "MATLAB_class", "MATLAB_object_decode", "MATLAB_empty"
OBJECTS = "#subsystem#"  # HDF5 group with the contents of MATLAB objects
DEEPEST, MOST = 12, 20_000  # maximum depth of structures, maximum number of arrays


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file has the signature of HDF5."""
    return any(head[at : at + 8] == SIGNATURE for at in HEADS)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table of all vectors of the file, then each MATLAB table and timetable.

    All vectors that a log uses must have the same length.
    """
    open_log(path).close()
    return open_guarded(path, _open)


def _open(path: Path) -> Sequence[LibraryTable]:
    import h5py

    file = h5py.File(path, "r")
    columns: dict[str, HdfVector] = {}
    others: dict[str, str] = {}
    for number, (name, item) in enumerate(_inside("", file, 0)):
        if number > MOST:
            raise LogError(path, f"has more than {MOST} arrays")
        described = dict(_columns(name, item)) if isinstance(item, h5py.Dataset) else {}
        columns |= described
        if name not in described:
            others[name] = _described(item)
    objects: Sequence[LibraryTable] = ()
    if OBJECTS in file and mat_objects.can_read():
        objects = mat_objects.open_objects(path)
    if not columns and objects:
        return objects
    if not columns:
        raise LogError(
            path,
            "has no real numeric vector; found: "
            f"{listed([f'{name} ({text})' for name, text in others.items()])}",
        )
    units = dict.fromkeys(columns)
    return (HdfTable(source=str(path), columns=columns, units=units, others=others), *objects)


def _inside(prefix: str, group: Any, depth: int) -> Iterator[tuple[str, Any]]:
    import h5py

    for key in group:
        # `#refs#` contains the targets of references
        if not key.startswith("#") and isinstance(group.get(key, getlink=True), h5py.HardLink):
            yield from _item(f"{prefix}.{key}" if prefix else key, group[key], depth)


def _item(name: str, item: Any, depth: int) -> Iterator[tuple[str, Any]]:
    import h5py

    yield name, item
    if depth >= DEEPEST or OBJECT in item.attrs:
        return
    if isinstance(item, h5py.Group):
        yield from _inside(name, item, depth + 1)
    elif item.dtype == h5py.ref_dtype and EMPTY not in item.attrs:
        is_cell = _class(item) == "cell"
        owner, _, key = name.rpartition(".")
        for number, reference in enumerate(item[()].ravel() if item.size <= MOST else (), start=1):
            if reference:
                yield from _item(
                    f"{name}{{{number}}}" if is_cell else f"{owner}({number}).{key}",
                    item.file[reference],
                    depth + 1,
                )


def _class(item: Any) -> str:
    value = item.attrs.get(CLASS, b"")
    return value.decode("latin-1") if isinstance(value, bytes) else str(value)


def _described(item: Any) -> str:
    import h5py

    if OBJECT in item.attrs:
        return f"{_class(item)}: {ADVICE}"
    if isinstance(item, h5py.Group):
        return _class(item) or "a group"
    shape = item.shape[::-1] if CLASS in item.attrs else item.shape
    kind = "complex" if item.dtype.names else _class(item) or str(item.dtype)
    return f"{'empty ' * (EMPTY in item.attrs)}{'x'.join(map(str, shape))} {kind}"


@dataclass(frozen=True)
class HdfVector:
    """Vector in a dataset of HDF5.

    index: for each axis of the dataset, the index of the vector; None for the axis along which the
        vector extends.
    rows: number of values.
    """

    dataset: Any
    index: tuple[int | None, ...]
    rows: int

    def read(self, first: int, n: int) -> Vector:
        """Return the `n` values (n,) of the vector from index `first` on."""
        where = tuple(slice(first, first + n) if one is None else one for one in self.index)
        return np.asarray(self.dataset[where]).astype(np.float64)


def _columns(name: str, dataset: Any) -> Iterator[tuple[str, HdfVector]]:
    elsewhere = dataset.external is not None or dataset.is_virtual
    if (
        dataset.dtype.kind not in "iufb"
        or _class(dataset) == "char"
        or not dataset.shape
        or elsewhere
    ):
        return
    if EMPTY in dataset.attrs or OBJECT in dataset.attrs:
        return
    is_matlab = CLASS in dataset.attrs
    shape = dataset.shape[::-1] if is_matlab else dataset.shape
    for line in lines(name, shape):
        sides = [number for number, n in enumerate(shape) if n != 1]
        if len(sides) == 1:
            index: list[int | None] = [
                None if number == sides[0] else 0 for number in range(len(shape))
            ]
        elif line.stride == 1:
            index = [None, line.first // shape[0]]
        else:
            index = [line.first, None]
        yield line.name, HdfVector(dataset, tuple(index[::-1] if is_matlab else index), line.rows)


class HdfTable(LibraryTable):
    """Table of the vectors in an HDF5 file."""

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks) until a block cannot be decoded."""
        chosen = {name: self.columns[name] for name in wanted}
        rows = common_rows(self.source, {name: line.rows for name, line in chosen.items()})
        check_rows(self.source, self.size, rows, len(chosen))
        for first in range(0, rows, BLOCK_ROWS):
            n = min(BLOCK_ROWS, rows - first)
            try:
                columns = {name: line.read(first, n) for name, line in chosen.items()}
            # h5py raises these exceptions for errors of HDF5
            except (OSError, ValueError, RuntimeError) as error:
                reason = f"is damaged after {first} of {rows} samples: {error}"
                if losses is None:
                    raise LogError(self.source, reason) from None
                losses.append(DataLoss((), reason, samples=rows - first))
                return
            yield RowBlock(first, columns), self.size * (first + n) // rows
