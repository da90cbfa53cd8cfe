"""One stream on its way into a log: samples in SI, piece after piece, from a raw table (mapping.py)
or from a canonical log.

Flow ──samples──▶ merged in time (assembly.py) ──▶ CanonicalWriter
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple, Protocol

from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.log import Vector
from frictool.logs.losses import LossList
from frictool.logs.table import Nanoseconds


class SampleBlock(NamedTuple):
    """Samples of one stream that follow one another: time (n,) in ns, strictly increasing; one
    vector (n,) in SI for each field."""

    time: Nanoseconds
    values: tuple[Vector, ...]

    def part(self, low: int, high: int) -> SampleBlock:
        return SampleBlock(self.time[low:high], tuple(values[low:high] for values in self.values))


class StreamSource(Protocol):
    """head: topic, fields and units. columns: field -> the raw column that it was made from, where
    it was.

    clock: what dates the samples; None where times are the log's already, counted from where the
    log says. size, done: bytes to work through, and worked through so far. losses: what could not
    be read, filled while `samples` runs. warnings: what was merely odd, complete when `samples` has
    ended.
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
        """The samples. Raises LogError where the file is damaged or a value is none; with `salvage`
        it is left out and told in `losses`."""
        ...
