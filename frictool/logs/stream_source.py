"""Interface of the streams from which a log is made; they yield samples in SI, block after block.

The samples come from a raw table (mapping.py) or from a canonical log.

    StreamSource ──samples──▶ merged in time (log_assembly.py) ──▶ CanonicalWriter
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple, Protocol

from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.losses import LossList
from frictool.logs.raw_table import Nanoseconds
from frictool.typing import Vector


class SampleBlock(NamedTuple):
    """Consecutive samples of one stream.

    time: times (n,) in ns, strictly increasing.
    values: one vector (n,) in SI for each field of the stream.
    """

    time: Nanoseconds
    values: tuple[Vector, ...]

    def part(self, low: int, high: int) -> SampleBlock:
        """Return the samples with the indices low <= k < high."""
        return SampleBlock(self.time[low:high], tuple(values[low:high] for values in self.values))


class StreamSource(Protocol):
    """Source of the samples of one stream.

    source: file name for messages.
    head: topic, fields and units.
    columns: for each field that comes from a single raw column, the name of this column.
    clock: name of the clock that gave the sample times; None if the times are already the log's
        time.
    size: total number of bytes to process.
    done: number of bytes processed so far.
    losses: data that could not be read; filled while `samples` runs.
    warnings: warnings that are not losses; complete when `samples` has ended.
    """

    source: str
    head: StreamHeader
    columns: Mapping[str, str]
    clock: str | None
    size: int
    done: int
    losses: LossList
    warnings: tuple[str, ...]

    def samples(self, salvage: bool = False) -> Iterator[SampleBlock]:
        """Yield the samples in blocks.

        Raises LogError if the file is damaged or a value is not valid. If `salvage` is True, such
        data is left out and recorded in `losses`.
        """
        ...
