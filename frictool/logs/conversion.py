"""Conversion of logs to the formats of other tools; each format has a module with `write`.

The streams are written one after the other, block by block if the format allows it. Each stream is
written as `time [s]`, followed by its signals in SI with their units. Reading the file back gives
the same numbers, bit for bit.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import BinaryIO, Protocol, cast

from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.formats import WRITTEN, Format
from frictool.logs.raw_table import BLOCK_ROWS
from frictool.logs.stream_source import SampleBlock
from frictool.typing import Vector

TIME_NAME, TIME_UNIT = "time", "s"


@dataclass
class OutgoingStream:
    """Stream that is to be written in another format; its samples can be read only once."""

    head: StreamHeader
    samples: Iterator[SampleBlock]

    @property
    def names(self) -> tuple[str, ...]:
        """Return the column names: `time`, then the names of the signals."""
        return (TIME_NAME, *self.head.fields)

    @property
    def units(self) -> tuple[str, ...]:
        """Return the units of the columns: s for the time, then the units of the signals."""
        return (TIME_UNIT, *self.head.units)

    def blocks(self) -> Iterator[list[Vector]]:
        """Yield blocks of rows; a block is a list of vectors: the time in s, then the signals.

        A block has at least BLOCK_ROWS rows; only the last block may be shorter.
        """
        pending: list[SampleBlock] = []
        for piece in self.samples:
            pending.append(piece)
            if sum(part.time.size for part in pending) >= BLOCK_ROWS:
                yield _columns(join_blocks(pending))
                pending = []
        if pending:
            yield _columns(join_blocks(pending))

    def whole(self) -> list[Vector]:
        """Return all samples as a list of vectors: the time in s, then the signals."""
        return _columns(join_blocks([*self.samples]))


def _columns(samples: SampleBlock) -> list[Vector]:
    return [samples.time / NS, *samples.values]


class FormatWriter(Protocol):
    """Interface of a module that writes log files in one format."""

    def write(self, streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
        """Write the streams and the metadata records `notes` to `target`."""


def convert(
    source: str, streams: Sequence[OutgoingStream], notes: Notes, form: Format, target: BinaryIO
) -> None:
    """Write the streams and the metadata records `notes` to `target` in the format `form`.

    Raises LogError with the file name `source` if there are several streams, but a file in this
    format can contain only one stream.
    """
    if len(streams) > 1 and not form.several:
        topics = ", ".join(stream.head.topic for stream in streams)
        several = ", ".join(name for name, other in WRITTEN.items() if other.several)
        raise LogError(
            source,
            f"has {len(streams)} streams, {topics}; a {form.name} file can contain only one; "
            f"select one with --stream, or convert to {several}",
        )
    cast(FormatWriter, importlib.import_module(form.writer)).write(streams, notes, target)


def flat_names(streams: Sequence[OutgoingStream]) -> list[str]:
    """Return a name without slashes for each stream, such as `axis_force` for `/axis/force`.

    If two streams would get the same name, a number is appended to the second name.
    """
    names: list[str] = []
    for stream in streams:
        name = stem = stream.head.topic.strip("/").replace("/", "_")
        number = 2
        while name in names:
            name = f"{stem}_{number}"
            number = number + 1
        names.append(name)
    return names
