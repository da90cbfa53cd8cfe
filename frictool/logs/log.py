"""A log in memory.

A `Log` holds one `Stream` per time base: `/axis`, and `/axis/NAME` for a further instrument or a
further simulated variant. A stream is a time vector [s] and signals of the same length, each in SI,
named as in the canonical MCAP: `position`, `reference`, `current`, ...
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError

Vector = NDArray[np.float64]
MAIN_TOPIC = "/axis"
MECHANISM_TOPIC = "/mechanism"  # beside it, of a simulated mechanism: all blocks
EXCITATION = "excitation"  # metadata record of a test of `frictool excite`: kind, rule, figures


@dataclass(frozen=True)
class Stream:
    """One time base: `time` (n,) in s, strictly increasing; `signals[name]` (n,) in SI;
    `units[name]` the SI unit."""

    topic: str
    time: Vector
    signals: dict[str, Vector]
    units: dict[str, str]

    def __post_init__(self) -> None:
        for name, values in self.signals.items():
            if values.shape != self.time.shape:
                raise ValueError(
                    f"signal {name!r} has {values.shape[0]} samples, time has {self.time.shape[0]}"
                )

    @property
    def period(self) -> float:
        """Median sample period in s."""
        return float(np.median(np.diff(self.time))) if self.time.size > 1 else float("nan")


@dataclass(frozen=True)
class Log:
    """Streams in the order of the file, and metadata records (name -> key -> text) such as
    `provenance`; units are in the streams.

    warnings: what reading a raw file noticed and let pass; they are told to the user and not
    stored.
    """

    streams: tuple[Stream, ...]
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    source: str = "log"
    warnings: tuple[str, ...] = ()

    @property
    def axes(self) -> tuple[Stream, ...]:
        """The streams of axes: all but those of a mechanism's blocks."""
        return tuple(one for one in self.streams if one.topic.split("/")[1] != MECHANISM_TOPIC[1:])

    @property
    def main(self) -> Stream:
        """The stream `/axis`, or the only stream. Raises LogError where there is none."""
        for stream in self.streams:
            if stream.topic == MAIN_TOPIC:
                return stream
        if len(self.streams) == 1:
            return self.streams[0]
        raise LogError(
            self.source,
            f"has no stream {MAIN_TOPIC}; found: {', '.join(s.topic for s in self.streams) or 'nothing'}",
        )

    def require(self, stream: Stream, *names: str) -> tuple[Vector, ...]:
        """The named signals of a stream. Raises LogError that lists what is missing and what the
        log has."""
        missing = [name for name in names if name not in stream.signals]
        if missing:
            raise LogError(
                self.source,
                f"stream {stream.topic} has no {' and no '.join(missing)}; found: {', '.join(stream.signals)}",
            )
        return tuple(stream.signals[name] for name in names)
