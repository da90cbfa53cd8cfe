"""The first samples of a stream, kept in memory: a log of hours shows in its opening which test it
is and which way its sensors count."""

from __future__ import annotations

from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.canonical.sample_chunks import join_blocks
from frictool.logs.log import Stream
from frictool.logs.stream_source import SampleBlock

LONGEST = 1 << 18  # samples


class OpeningSamples:
    """The opening of the stream that `head` describes, piece after piece."""

    def __init__(self, head: StreamHeader) -> None:
        self._head = head
        self._pieces: list[SampleBlock] = []
        self._samples = 0

    def take(self, piece: SampleBlock) -> None:
        """Adds samples that follow those before."""
        left = LONGEST - self._samples
        if left > 0:
            self._pieces.append(piece.part(0, left))
            self._samples += piece.time.size

    @property
    def stream(self) -> Stream:
        """What was kept, at least one sample."""
        samples = join_blocks(self._pieces)
        fields = self._head.fields
        units = dict(zip(fields, self._head.units, strict=True))
        return Stream(
            self._head.topic,
            samples.time / NS,
            dict(zip(fields, samples.values, strict=True)),
            units,
        )
