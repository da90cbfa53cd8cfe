"""Writer of a stream as a CSV file with the header `name [unit]`.

Each number is written with the fewest digits that represent it exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import OutgoingStream


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Write the single stream in `streams`; the metadata `notes` is not written."""
    (stream,) = streams
    target.write(
        (
            ",".join(
                f"{name} [{unit}]" for name, unit in zip(stream.names, stream.units, strict=True)
            )
            + "\n"
        ).encode()
    )
    for columns in stream.blocks():
        rows = zip(*(column.tolist() for column in columns), strict=True)
        target.write("".join(",".join(map(repr, row)) + "\n" for row in rows).encode())
