"""A stream as CSV: a header `name [unit]`, each number in the fewest digits that give it again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import OutgoingStream


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Writes the one stream. There is no place for the notes."""
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
