"""Tables of a recording of messages (MCAP, ROS 1 and ROS 2 bags), one for each topic with numbers.

Each topic has its own time base.

    container ──Messages, MessageGap, Messages, ...──▶ decoder ──numbers──▶ TopicTable

The name of a column is its path: `/joint_states.position[arm]`, `/motor.data`,
`/imu.linear_acceleration.x`. The name of an array element contains its index from 0.
If the message also has an array `name` of labels, the element has a second name with its label.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    SALVAGE,
    DataLoss,
    Nanoseconds,
    RowBlock,
    find,
)
from frictool.logs.recordings.serialised_messages import Messages
from frictool.typing import Vector

LOG_TIME = "log time"
# fields that may hold the time of a message's content
STAMPS = ("header.stamp", "stamp", "timestamp")
STAMP_PARTS = (("sec", "nanosec"), ("sec", "nsec"), ("seconds", "nanos"))
FARTHEST_APART = 3600.0  # s, largest difference of two clocks that are meant to show the same time
SAMPLED = 20  # number of messages of a topic that are read to list its numbers
PART_BYTES = 8_000_000  # bytes of messages decoded together
# types that describe the software and not the rig
HOUSEKEEPING = ("rcl_interfaces/", "rosgraph_msgs/", "bond/", "diagnostic_msgs/")


class MessageGap(NamedTuple):
    """Gap in a topic where messages cannot be read.

    reason: why the messages cannot be read.
    samples: number of unreadable messages; None if unknown.
    """

    reason: str
    samples: int | None = None


class Decoder(Protocol):
    """Decoder of the messages of one topic.

    The path of a number is its name within a message, such as `position[0]` or `pose.x`.
    """

    def names(self, data: bytes) -> list[str]:
        """Return the paths of the numbers in a message; raise ValueError if `data` is damaged."""
        ...

    def columns(
        self, messages: Messages, paths: tuple[str, ...]
    ) -> tuple[Vector, NDArray[np.bool_], dict[int, str]]:
        """Return (values, presence, failures) of the numbers at `paths` in n messages.

        values: numbers (paths, n); NaN for a missing number.
        presence: mask (paths, n) that is False for a missing number.
        failures: reason for each unreadable message, by the message's index.
        """
        ...


@dataclass
class Topic:
    """Topic of a recording.

    kind: name of the type of the messages.
    decoder: decoder of the messages; None if they cannot be decoded.
    refused: reason why the messages cannot be decoded; "" if they can be decoded.
    paths: paths of the numbers in the first messages, as keys of a dictionary (all values None).
    stamp: (path of the time stamp in the messages, paths of its seconds and nanoseconds); None if
        the messages have no stamp.
    apart_s: largest difference in s between stamp and log time. A large value means that the two
        clocks were not synchronised.
    sampled: number of messages from which `paths`, `stamp` and `apart_s` were read.
    """

    name: str
    kind: str
    decoder: Decoder | None = None
    refused: str = ""
    paths: dict[str, None] = field(default_factory=dict)
    stamp: tuple[str, tuple[str, ...]] | None = None
    apart_s: float = 0.0
    sampled: int = 0

    def sample(self, messages: Messages) -> None:
        """Set `paths`, `stamp` and `apart_s` from the topic's first messages.

        A damaged message only sets `refused` to the reason. A stamp that is 0 in all these messages
        is ignored.
        """
        first = messages.at(slice(0, max(0, SAMPLED - self.sampled)))
        self.sampled += first.start.size
        if self.decoder is None or not first.start.size:
            return
        for index in range(first.start.size):
            try:
                self.paths |= dict.fromkeys(self.decoder.names(first.payload(index)))
            except ValueError as error:
                self.refused = self.refused or str(error)
        for stamp, parts in _stamps(self.paths):
            seconds, nanoseconds = np.nan_to_num(self.decoder.columns(first, parts)[0])
            if self.stamp is None and (seconds.any() or nanoseconds.any()):
                self.stamp = stamp, parts
                self.apart_s = float(np.abs(seconds - first.log_time / NS).max())


class RecordingFile(Protocol):
    """Recording that is open for reading.

    source: file name for messages.
    size: size in bytes.
    """

    source: str
    size: int
    topics: dict[str, Topic]

    def messages(self, topic: str) -> Iterator[tuple[Messages | MessageGap, int]]:
        """Yield the messages of a topic and the gaps between them, in the order of the file.

        Each item is paired with the number of bytes processed so far.
        """
        ...


class TopicTable:
    """Table of the numbers of one topic (implements RawTable).

    clock: path of the time stamp that gives the times of the rows, or `log time`.
    """

    def __init__(self, container: RecordingFile, topic: Topic, clock: str | None) -> None:
        stamp = (
            topic.stamp
            if topic.stamp is not None and clock in (None, topic.stamp[0])
            else (LOG_TIME, ())
        )
        self._container = container
        self._topic = topic
        self._stamp = stamp[1]
        self.source, self.size, self.topic = container.source, container.size, topic.name
        # stamps give the times of the rows and are not signals
        parts = topic.stamp[1] if topic.stamp is not None else ()
        self.names = tuple(
            f"{topic.name}.{path}" for path in _listed(topic.paths) if path not in parts
        )
        self.units: Mapping[str, str | None] = dict.fromkeys(self.names)
        self.clock: str | None = stamp[0]

    def line(self, row: int) -> int | None:
        """Return None, because a recording has no lines."""
        return None

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing.

        An array element that has a label may also be requested by its index.

        Raises LogError if the topic has no numbers.
        """
        if isinstance(wanted, int) or not wanted.startswith(f"{self.topic}."):
            return find(self.names, wanted)
        if wanted[len(self.topic) + 1 :] in self._topic.paths:
            return wanted
        if not self.names:
            raise LogError(
                self.source,
                f"topic {self.topic} has no numbers: {self._topic.refused or self._topic.kind}",
            )
        return None

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows, one row for each message (see RawTable.blocks).

        A message that contains none of the requested numbers gives no row, because several
        publishers may share a topic.
        """
        decoder = self._topic.decoder
        if decoder is None:
            raise LogError(self.source, f"topic {self.topic}: {self._topic.refused}")
        paths = tuple(name.removeprefix(f"{self.topic}.") for name in wanted)
        read = rows = 0
        for piece, done in self._container.messages(self.topic):
            if isinstance(piece, MessageGap):
                self._lost(piece, losses)
                continue
            for part in _parts(piece):
                values, present, failed = decoder.columns(part, paths + self._stamp)
                for index, reason in failed.items():
                    when = f"log time {int(part.log_time[index]) / NS:.9g} s"
                    self._lost(
                        MessageGap(f"message {read + index + 1}, recorded at {when}, {reason}", 1),
                        losses,
                    )
                read += part.start.size
                rowed = present[: len(paths)].any(axis=0)
                kept = values[:, rowed]
                if kept.shape[1]:
                    time = self._times(part.log_time[rowed], kept[len(paths) :])
                    recorded = part.log_time[rowed] if self._stamp else None
                    yield (
                        RowBlock(rows, dict(zip(wanted, kept, strict=False)), time, recorded),
                        done,
                    )
                    rows += kept.shape[1]

    def _times(self, log_time: Nanoseconds, stamp: Vector) -> Nanoseconds:
        if not self._stamp:
            return log_time
        bad = ~np.isfinite(stamp).all(axis=0) | (np.abs(stamp) > 9e9).any(axis=0)
        if bad.any():
            raise LogError(
                self.source,
                f"topic {self.topic}: a message has no {self.clock}; write layout.clock: "
                f"'{LOG_TIME}' in bench.yaml",
            )
        seconds, nanoseconds = stamp.astype(np.int64)
        time: Nanoseconds = seconds * NS + nanoseconds
        return time

    def _lost(self, gap: MessageGap, losses: list[DataLoss] | None) -> None:
        if losses is None:
            raise LogError(self.source, f"{gap.reason} (topic {self.topic}); {SALVAGE}")
        losses.append(DataLoss((), gap.reason, samples=gap.samples))


def tables_of(container: RecordingFile, clock: str | None = None) -> tuple[TopicTable, ...]:
    """Return a table for each topic; the table of a topic without numbers has no columns.

    clock: `log time`, or the path of a stamp in the messages. None selects the stamp of each topic,
        or the log time of a topic without stamps. If some topics have no stamps, and stamps
        differ from the log time by more than FARTHEST_APART, None selects the log time of all
        topics.

    Raises LogError if no topic has numbers, or if no topic has the requested clock.
    """
    carrying = [
        topic
        for topic in container.topics.values()
        if topic.paths and not topic.kind.startswith(HOUSEKEEPING)
    ]
    if not carrying:
        seen = [
            f"{topic.name} ({topic.refused or topic.kind or 'no type'})"
            for topic in container.topics.values()
        ]
        raise LogError(container.source, f"has no topic with numbers; found: {listed(seen)}")
    known = sorted({LOG_TIME, *(topic.stamp[0] for topic in carrying if topic.stamp)})
    if clock not in (None, *known):
        raise LogError(
            container.source, f"no topic has the clock {clock!r}; found: {', '.join(known)}"
        )
    if (
        clock is None
        and any(topic.stamp is None for topic in carrying)
        and max(topic.apart_s for topic in carrying) > FARTHEST_APART
    ):
        clock = LOG_TIME
    return tuple(TopicTable(container, topic, clock) for topic in container.topics.values())


def _stamps(paths: Mapping[str, None]) -> Iterator[tuple[str, tuple[str, ...]]]:
    for stamp in STAMPS:
        for parts in STAMP_PARTS:
            named = tuple(f"{stamp}.{part}" for part in parts)
            if all(part in paths for part in named):
                yield stamp, named


def _listed(paths: Mapping[str, None]) -> list[str]:
    elements = [(path, *path[:-1].rpartition("[")[::2]) for path in paths if path.endswith("]")]
    labelled = {array for _, array, key in elements if not key.isdigit()}
    again = {path for path, array, key in elements if key.isdigit() and array in labelled}
    return [path for path in paths if path not in again]


def _parts(messages: Messages) -> Iterator[Messages]:
    ends = np.cumsum(messages.length)
    first, before = 0, 0
    while first < messages.start.size:
        last = min(
            int(np.searchsorted(ends, before + PART_BYTES, side="right")), first + BLOCK_ROWS
        )
        last = max(last, first + 1)
        yield messages.at(slice(first, last))
        first = last
        before = int(ends[last - 1])
