"""The first samples of a stream, kept in memory: a log of hours shows in its opening which test it is and which way its sensors count."""

from __future__ import annotations

from frictool.logs.canonical.chunks import joined
from frictool.logs.canonical.mcap_layout import NS, Head
from frictool.logs.flow import Samples
from frictool.logs.log import Stream

LONGEST = 1 << 18  # samples


class Opening:
    """The opening of the stream that `head` describes, piece after piece."""

    def __init__(self, head: Head) -> None:
        self._head = head
        self._pieces: list[Samples] = []
        self._samples = 0

    def take(self, piece: Samples) -> None:
        """Adds samples that follow those before."""
        left = LONGEST - self._samples
        if left > 0:
            self._pieces.append(piece.part(0, left))
            self._samples += piece.time.size

    @property
    def stream(self) -> Stream:
        """What was kept, at least one sample."""
        samples = joined(self._pieces)
        fields = self._head.fields
        units = dict(zip(fields, self._head.units, strict=True))
        return Stream(self._head.topic, samples.time / NS, dict(zip(fields, samples.values, strict=True)), units)
