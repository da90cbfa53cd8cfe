"""From a log to the formats of other tools: one module each, `write(streams, notes, target)`.

    Ready streams ──regrouped──▶ writer ──▶ bytes; one stream at a time, block after block where the
    format allows it

All give the same numbers again, bit for bit, when they are read: `time [s]`, then the signals in SI
with their units.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol, cast

from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.log import Vector
from frictool.logs.optional_libraries import library
from frictool.logs.stream_source import SampleBlock
from frictool.logs.table import BLOCK_ROWS

TIME_NAME, TIME_UNIT = "time", "s"


@dataclass
class OutgoingStream:
    """A stream on its way out: what it is, and its samples, which can be taken once."""

    head: StreamHeader
    samples: Iterator[SampleBlock]

    @property
    def names(self) -> tuple[str, ...]:
        return (TIME_NAME, *self.head.fields)

    @property
    def units(self) -> tuple[str, ...]:
        return (TIME_UNIT, *self.head.units)

    def blocks(self) -> Iterator[list[Vector]]:
        """Time [s] and the signals, BLOCK_ROWS or somewhat more at once."""
        held: list[SampleBlock] = []
        for piece in self.samples:
            held.append(piece)
            if sum(part.time.size for part in held) >= BLOCK_ROWS:
                yield _columns(join_blocks(held))
                held = []
        if held:
            yield _columns(join_blocks(held))

    def whole(self) -> list[Vector]:
        """All of it at once."""
        return _columns(join_blocks([*self.samples]))


def _columns(samples: SampleBlock) -> list[Vector]:
    return [samples.time / NS, *samples.values]


class FormatWriter(Protocol):
    """What the module of a format has."""

    def write(self, streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None: ...


class OutputFormat(NamedTuple):
    """A format: the ends of its files' names, its module, whether a file holds several streams, the
    library it needs and of which extra."""

    suffixes: tuple[str, ...]
    module: str
    several: bool
    needs: tuple[str, str] | None = None


CONVERSIONS = {
    "csv": OutputFormat((".csv",), "frictool.logs.text.csv_writer", False),
    "mat": OutputFormat((".mat",), "frictool.logs.arrays.mat_writer", True),
    "mdf": OutputFormat(
        (".mf4", ".mdf"), "frictool.logs.arrays.mdf_writer", True, ("asammdf", "mdf")
    ),
    "npz": OutputFormat((".npz",), "frictool.logs.arrays.npz_writer", True),
    "parquet": OutputFormat(
        (".parquet", ".pq"),
        "frictool.logs.arrays.parquet_writer",
        False,
        ("pyarrow.parquet", "parquet"),
    ),
}


def format_for(path: Path) -> str | None:
    """The format that a file's name asks for."""
    return next(
        (name for name, one in CONVERSIONS.items() if path.suffix.lower() in one.suffixes), None
    )


def require(kind: str, target: Path) -> None:
    """Raises LogError about `target` where the library that writes its format is not installed."""
    needs = CONVERSIONS[kind].needs
    if needs is not None:
        library(target, *needs)


def convert(
    source: str, streams: Sequence[OutgoingStream], notes: Notes, kind: str, target: BinaryIO
) -> None:
    """Writes the streams in a format of CONVERSIONS. Raises LogError where one file cannot hold
    them all."""
    one = CONVERSIONS[kind]
    if len(streams) > 1 and not one.several:
        topics = ", ".join(stream.head.topic for stream in streams)
        several = ", ".join(name for name, other in CONVERSIONS.items() if other.several)
        raise LogError(
            source,
            f"has {len(streams)} streams, {topics}; a {kind} file holds one: name it with --stream, or convert to {several}",
        )
    cast(FormatWriter, importlib.import_module(one.module)).write(streams, notes, target)


def flat_names(streams: Sequence[OutgoingStream]) -> list[str]:
    """A name for each stream without slashes, `axis_force` for `/axis/force`, with a number where
    another has it already."""
    names: list[str] = []
    for stream in streams:
        name = stem = stream.head.topic.strip("/").replace("/", "_")
        number = 2
        while name in names:
            name, number = f"{stem}_{number}", number + 1
        names.append(name)
    return names
