"""Reader of Parquet files in batches of rows, with pyarrow (extra `parquet`).

Nested fields are named `a.b`. Units are read from the metadata of the fields. The first column of
timestamps gives the times of the rows, exact to 1 ns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.array_table import check_rows
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    SALVAGE,
    DataLoss,
    Nanoseconds,
    RawTable,
    RowBlock,
)
from frictool.typing import Vector

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

MAGIC = b"PAR1"
UNIT = b"unit"  # key in a field's metadata
BUFFER = 1 << 20  # bytes of a column in one read
DEEPEST = 8  # maximum depth of structures


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins with the signature of Parquet."""
    return head.startswith(MAGIC)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the table of the file.

    Raises LogError if the footer is damaged or missing, or if no column has numbers.
    """
    with open_log(path) as stream:
        stream.seek(-min(len(MAGIC), path.stat().st_size), 2)
        if stream.read() != MAGIC:
            raise LogError(
                path,
                (
                    "is cut off: the footer that describes its columns is missing, so that nothing "
                    "can be salvaged; copy or export the file again"
                ),
            )
    return open_guarded(path, _open)


def _open(path: Path) -> Sequence[LibraryTable]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pa.set_cpu_count(1)
    pa.set_io_thread_count(1)
    pa.set_memory_pool(pa.system_memory_pool())  # this pool returns free memory to the system
    file = pq.ParquetFile(
        path, buffer_size=BUFFER, pre_buffer=False, page_checksum_verification=True
    )
    flat = [(name, field) for one in file.schema_arrow for name, field in _flat(one.name, one, 0)]
    count = Counter(name for name, _ in flat)
    fields = dict(flat)
    columns = {name: field for name, field in flat if _is_number(field.type) and count[name] == 1}
    clock = next(
        (
            name
            for name, field in fields.items()
            if pa.types.is_timestamp(field.type) and count[name] == 1
        ),
        None,
    )
    several = "a name that several columns have"
    others = {
        name: f"a column of {field.type}" if count[name] == 1 else several
        for name, field in fields.items()
        if name not in columns
    }
    if not columns:
        raise LogError(
            path,
            "has no column of real numbers; found: "
            f"{listed([f'{name} ({field.type})' for name, field in fields.items()])}",
        )
    return (
        ParquetTable(
            source=str(path),
            columns=columns,
            units={name: _unit(field) for name, field in columns.items()},
            others=others,
            clock=clock,
            file=file,
        ),
    )


def _flat(name: str, field: Any, depth: int) -> Iterator[tuple[str, Any]]:
    import pyarrow as pa

    if not pa.types.is_struct(field.type) or depth == DEEPEST:
        yield name, field
        return
    for inner in field.type:
        yield from _flat(f"{name}.{inner.name}", inner, depth + 1)


def _is_number(kind: Any) -> bool:
    import pyarrow as pa

    checks = (
        pa.types.is_integer,
        pa.types.is_floating,
        pa.types.is_boolean,
        pa.types.is_decimal,
        pa.types.is_duration,
    )
    return any(check(kind) for check in checks)


def _unit(field: Any) -> str | None:
    import pyarrow as pa

    if pa.types.is_duration(field.type):
        return str(field.type.unit)
    return (field.metadata or {}).get(UNIT, b"").decode(errors="replace") or None


@dataclass(kw_only=True)
class ParquetTable(LibraryTable):
    """Table of the rows of an open Parquet file."""

    file: Any

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks).

        After damage in a row group, the later rows of this group are lost; reading continues with
        the next group.
        """
        chosen = [*wanted, *([] if self.clock is None else [self.clock])]
        total = self.file.metadata.num_rows
        row = 0
        check_rows(self.source, self.size, total, len(chosen))
        for group in range(self.file.num_row_groups):
            end = row + self.file.metadata.row_group(group).num_rows
            try:
                for batch in self.file.iter_batches(
                    BLOCK_ROWS, row_groups=[group], columns=chosen, use_threads=False
                ):
                    if batch.num_rows:
                        yield (
                            self._block(row, batch, wanted),
                            self.size * min(row + batch.num_rows, total) // max(total, 1),
                        )
                    row += batch.num_rows
                if row != end:
                    raise ValueError(
                        f"this and the earlier groups declare {end} rows, but have {row}"
                    )
            except (OSError, ValueError) as error:  # pyarrow raises these
                reason = f"row group {group + 1} is damaged: {error}"
                if losses is None:
                    raise LogError(
                        self.source, f"{reason}; {row} rows were read before; {SALVAGE}"
                    ) from None
                losses.append(DataLoss((), reason, samples=max(end - row, 0)))
                row = end

    def _block(self, row: int, batch: Any, wanted: Sequence[str]) -> RowBlock:
        arrays = {name: _inside(batch, name) for name in wanted}
        time = None if self.clock is None else self._stamps(row, _inside(batch, self.clock))
        return RowBlock(row, {name: _numbers(array) for name, array in arrays.items()}, time)

    def _stamps(self, row: int, array: Any) -> Nanoseconds:
        import pyarrow as pa

        if array.null_count:
            raise LogError(
                self.source,
                f"column {self.clock!r} has no time in some of the rows {row + 1} to "
                f"{row + len(array)}",
            )
        exact: Nanoseconds = (
            array.cast(pa.timestamp("ns", array.type.tz))
            .cast(pa.int64())
            .to_numpy(zero_copy_only=False)
        )
        return exact


def _inside(batch: Any, path: str) -> Any:
    import pyarrow.compute as pc

    name = _first(batch.schema.names, path)
    array = batch.column(batch.schema.names.index(name))
    rest = path[len(name) :]
    while rest:  # a dot and the path inside the structure; the name of a field may be empty
        fields = [field.name for field in array.type]
        inner = _first(fields, rest[1:])
        array = pc.struct_field(array, [fields.index(inner)])
        rest = rest[1 + len(inner) :]
    return array


def _first(names: Sequence[str], path: str) -> str:
    return max((name for name in names if path == name or path.startswith(f"{name}.")), key=len)


def _numbers(array: Any) -> Vector:
    import pyarrow as pa

    if pa.types.is_duration(array.type):
        array = array.cast(pa.int64())
    if pa.types.is_boolean(array.type):
        array = array.cast(pa.uint8())
    numbers: Vector = (
        array.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False).astype(np.float64)
    )
    return numbers
