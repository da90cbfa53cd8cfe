"""Reader of MCAP recordings of other tools, with any topics, with or without chunks and summary."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel

from frictool.errors import LogError
from frictool.logs.canonical.mcap_bounds import record_bounds, whole_records
from frictool.logs.canonical.mcap_declarations import UNREADABLE, McapDeclarations, declared
from frictool.logs.canonical.mcap_layout import MAGIC
from frictool.logs.canonical.mcap_records import MESSAGE_HEAD, FileRecords
from frictool.logs.canonical.mcap_sections import FileSection, contents, error_text
from frictool.logs.open_file import open_log
from frictool.logs.recordings.decoders import topic_of
from frictool.logs.recordings.recording import SAMPLED, MessageGap, Topic
from frictool.logs.recordings.serialised_messages import Messages, gather

LONGEST_SUMMARY = 64_000_000  # bytes
_FOOTER = struct.Struct("<BQQQI")

MessagesByChannel = dict[int, Messages]  # channel -> messages


@dataclass
class McapLoss:
    """Loss of messages in an MCAP file.

    reason: why the messages cannot be read.
    of: number of lost messages of each channel; None if the channels are unknown.
    """

    reason: str
    of: dict[int, int] | None = None


@dataclass
class _McapPass:
    stream: BinaryIO
    size: int
    declarations: McapDeclarations = field(default_factory=McapDeclarations)

    @property
    def channels(self) -> dict[int, Channel]:
        return self.declarations.channels

    @property
    def counts(self) -> dict[int, int]:
        return self.declarations.counts or {}

    def pieces(self) -> Iterator[tuple[MessagesByChannel | McapLoss, int]]:
        """Yield messages and losses by chunk, each with the number of bytes processed so far."""
        for item, done in contents(FileRecords(self.stream, self.size)):
            if isinstance(item, FileSection):
                for piece in self._part(item):
                    yield piece, done
            else:
                self.take(item.opcode, item.body)

    def _part(self, part: FileSection) -> Iterator[MessagesByChannel | McapLoss]:
        if part.data:
            try:
                yield self._grouped(part)
            except UNREADABLE as error:
                part.reason = part.reason or f"a chunk cannot be read ({error_text(error)})"
        if part.reason and part.joined:
            for one in part.joined:
                yield from self._part(one)
        elif part.reason:
            counts = {channel: times.size for channel, times in part.indexed()}
            of = counts or ({} if part.empty else None)
            yield McapLoss(
                f"is damaged or cut off at byte {part.at} of {self.size}: {part.reason}", of
            )

    def _grouped(self, part: FileSection) -> MessagesByChannel:
        data = part.data
        bounds = record_bounds(data) if part.whole else whole_records(data)[0]
        for opcode, body in declared(data, bounds):
            self.take(opcode, body)
        which = bounds.opcode == Opcode.MESSAGE
        start = bounds.start[which]
        length = bounds.length[which] - MESSAGE_HEAD
        if (length < 0).any():
            raise ValueError("a message is shorter than its header")
        plain = np.frombuffer(data, np.uint8)
        channel = gather(plain, start, 2).view("<u2")[:, 0]
        log_time = gather(plain, start + 6, 8).view("<i8")[:, 0]
        if (log_time < 0).any():
            raise ValueError("a message was recorded after the year 2262")
        messages = Messages(log_time, plain, start + MESSAGE_HEAD, length)
        return {
            number: messages.at(np.flatnonzero(channel == number))
            for number in np.unique(channel).tolist()
        }

    def take(self, opcode: int, body: bytes) -> None:
        """Store the schema, the channel or the counts that a record declares.

        A damaged record is skipped. When a message of the record's channel is read, the damage is
        reported.
        """
        with suppress(*UNREADABLE):
            self.declarations.take(opcode, body)


class McapRecording:
    """MCAP recording of another tool (implements RecordingFile)."""

    def __init__(self, path: Path) -> None:
        """Open the file and read its topics; raise LogError if the file cannot be read."""
        self.source = str(path)
        self._path = path
        self.topics: dict[str, Topic] = {}
        with open_log(path) as stream:
            try:
                self.size = stream.seek(0, 2)
                self._look(stream)
            except OSError as error:
                raise LogError(path, f"cannot be read: {error.strerror or error}") from None

    def messages(self, topic: str) -> Iterator[tuple[Messages | MessageGap, int]]:
        """Yield the messages (see RecordingFile); raise LogError if the file cannot be read."""
        count = 0
        unknown = False
        with open_log(self._path) as stream:
            one = _McapPass(
                stream,
                self.size,
                McapDeclarations(
                    dict(self._declarations.schemas), dict(self._declarations.channels)
                ),
            )
            try:
                for piece, done in one.pieces():
                    for item in self._of_topic(one, piece, topic):
                        count += (
                            item.start.size if isinstance(item, Messages) else (item.samples or 0)
                        )
                        unknown |= isinstance(item, MessageGap) and item.samples is None
                        yield item, done
            except OSError as error:
                raise LogError(self._path, f"cannot be read: {error.strerror or error}") from None
        declared = sum(
            one.counts.get(number, 0)
            for number, channel in one.channels.items()
            if channel.topic == topic
        )
        if count < declared and not unknown:
            yield (
                MessageGap(
                    f"{count} messages are present, but the file declares {declared}",
                    declared - count,
                ),
                self.size,
            )

    def _of_topic(
        self, one: _McapPass, piece: MessagesByChannel | McapLoss, topic: str
    ) -> Iterator[Messages | MessageGap]:
        mine = {number for number, channel in one.channels.items() if channel.topic == topic}
        if isinstance(piece, McapLoss):
            counts = (
                None
                if piece.of is None
                else [
                    count
                    for number, count in piece.of.items()
                    if number in mine or number not in one.channels
                ]
            )
            if counts != [] or not piece.of:
                yield MessageGap(piece.reason, None if counts is None else sum(counts))
            return
        for number, messages in piece.items():
            if number in mine and self._kind(one, number) == self.topics[topic].kind:
                yield messages
            elif number in mine or number not in one.channels:
                kind = self._kind(one, number) if number in mine else "an undeclared channel"
                yield MessageGap(
                    f"{messages.start.size} messages are of {kind}",
                    messages.start.size if number in mine else None,
                )

    @staticmethod
    def _kind(one: _McapPass, number: int) -> str:
        schema = one.declarations.schemas.get(one.channels[number].schema_id)
        return "" if schema is None else schema.name

    def _look(self, stream: BinaryIO) -> None:
        one = _McapPass(stream, self.size)
        self._summary(stream, one)
        left = {number for number, count in one.counts.items() if count}
        known = bool(left)
        stream.seek(0)
        for piece, _ in one.pieces():
            for channel in one.channels.values():
                self._declared(one, channel)
            for number, messages in piece.items() if isinstance(piece, dict) else ():
                if number not in one.channels:
                    continue
                topic = self.topics[one.channels[number].topic]
                topic.sample(messages)
                if topic.sampled >= min(SAMPLED, one.counts.get(number, 0)):
                    left.discard(number)
            if known and not left:
                break
        self._declarations = one.declarations

    def _declared(self, one: _McapPass, channel: Channel) -> None:
        if channel.topic not in self.topics:
            schema = one.declarations.schemas.get(channel.schema_id)
            kind, form, text = (
                ("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data)
            )
            self.topics[channel.topic] = topic_of(
                self._path, channel.topic, kind, channel.message_encoding, form, text
            )

    def _summary(self, stream: BinaryIO, one: _McapPass) -> None:
        end = self.size - len(MAGIC) - _FOOTER.size
        if end < 0:
            return
        stream.seek(end)
        opcode, _, start, _, _ = _FOOTER.unpack(stream.read(_FOOTER.size))
        if opcode != Opcode.FOOTER or not 0 < start <= end or end - start > LONGEST_SUMMARY:
            return
        stream.seek(start)
        data = stream.read(end - start)
        bounds, _ = whole_records(data)
        for kind, first, length in zip(
            bounds.opcode.tolist(), bounds.start.tolist(), bounds.length.tolist(), strict=True
        ):
            one.take(kind, data[first : first + length])
