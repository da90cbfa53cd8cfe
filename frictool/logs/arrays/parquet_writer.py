"""Writer of a stream as a Parquet file, with pyarrow (extra `parquet`).

Values are doubles. The metadata of each field contains its unit; the metadata of the schema
contains the metadata records of the log.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import BinaryIO

from frictool.logs.arrays.parquet_format import UNIT
from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import OutgoingStream


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Write the single stream in `streams`; each block becomes a row group."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    (stream,) = streams
    named = zip(stream.names, stream.units, strict=True)
    fields = [
        pa.field(name, pa.float64(), nullable=False, metadata={UNIT: unit}) for name, unit in named
    ]
    schema = pa.schema(
        fields,
        metadata={name: json.dumps(entries, ensure_ascii=False) for name, entries in notes.items()},
    )
    with pq.ParquetWriter(
        target, schema, compression="zstd", use_dictionary=False, write_page_checksum=True
    ) as writer:
        for columns in stream.blocks():
            writer.write_table(pa.table(columns, schema=schema))
