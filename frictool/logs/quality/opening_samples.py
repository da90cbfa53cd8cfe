"""First samples of a stream, from which the kind of test and the sensors' signs are recognised."""

from __future__ import annotations

from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.log import Stream
from frictool.logs.stream_source import SampleBlock

LONGEST = 1 << 18  # maximum number of samples kept


class OpeningSamples:
    """First samples of the stream with header `head`, collected block after block."""

    def __init__(self, head: StreamHeader) -> None:
        self._head = head
        self._pieces: list[SampleBlock] = []
        self._samples = 0

    def take(self, piece: SampleBlock) -> None:
        """Add the next samples; samples after the first LONGEST samples are ignored."""
        left = LONGEST - self._samples
        if left > 0:
            self._pieces.append(piece.part(0, left))
            self._samples += piece.time.size

    @property
    def stream(self) -> Stream:
        """Return the first samples as a stream; at least one sample must have been added."""
        samples = join_blocks(self._pieces)
        fields = self._head.fields
        units = dict(zip(fields, self._head.units, strict=True))
        return Stream(
            self._head.topic,
            samples.time / NS,
            dict(zip(fields, samples.values, strict=True)),
            units,
        )
