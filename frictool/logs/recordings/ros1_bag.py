"""Reader of ROS 1 bags (`.bag`, version 2.0).

A bag consists of records. Each record has a header of named fields, and data. Chunk records contain
the messages.
"""

from __future__ import annotations

import bz2
import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from frictool.errors import LogError
from frictool.logs.open_file import open_log
from frictool.logs.recordings.decoders import topic_of
from frictool.logs.recordings.recording import SAMPLED, MessageGap, Topic
from frictool.logs.recordings.serialised_messages import Messages, pack_messages
from frictool.logs.unpacked_size import UnpackedBudget

MAGIC = b"#ROSBAG V2.0\n"
LARGEST_CHUNK = 256_000_000  # bytes, maximum plain size of a chunk
LONGEST_HEADER = 1_000_000  # bytes, maximum size of a record's header
MESSAGE, BAG_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
NS = 1_000_000_000
_U32 = struct.Struct("<I")
_TIME = struct.Struct("<II")

Fields = dict[bytes, bytes]
TopicMessages = dict[str, tuple[list[int], list[bytes]]]  # topic -> log times and payloads


@dataclass
class BagLoss:
    """Loss of messages in a bag.

    reason: why the messages cannot be read.
    rest: for each topic, messages of the damaged part that can still be read.
    """

    reason: str
    rest: TopicMessages


class BagRecording:
    """ROS 1 bag (implements RecordingFile)."""

    def __init__(self, path: Path) -> None:
        """Open the file and read its topics; raise LogError if the file cannot be read."""
        self.source = str(path)
        self._path = path
        self.size = 0
        self.topics: dict[str, Topic] = {}
        self._names: dict[int, str] = {}  # connection -> topic
        with open_log(path) as stream:
            try:
                self.size = os.fstat(stream.fileno()).st_size
                listed = self._list(stream)
                for piece, _ in self._pieces(stream):
                    for topic, (times, payloads) in (
                        piece.rest if isinstance(piece, BagLoss) else piece
                    ).items():
                        if self.topics[topic].sampled < SAMPLED:
                            self.topics[topic].sample(pack_messages(times, payloads))
                    if listed and all(self.topics[topic].sampled for topic in listed):
                        break
            except OSError as error:
                raise LogError(path, f"cannot be read: {error.strerror or error}") from None

    def messages(self, topic: str) -> Iterator[tuple[Messages | MessageGap, int]]:
        """Yield the messages (see RecordingFile); raise LogError if the file cannot be read."""
        with open_log(self._path) as stream:
            try:
                for piece, done in self._pieces(stream):
                    whole = piece.rest if isinstance(piece, BagLoss) else piece
                    if topic in whole:
                        yield pack_messages(*whole[topic]), done
                    if isinstance(piece, BagLoss):
                        yield MessageGap(piece.reason), done
            except OSError as error:
                raise LogError(self._path, f"cannot be read: {error.strerror or error}") from None

    def _list(self, stream: BinaryIO) -> set[str]:
        """Return the topics that have messages according to the index of the bag.

        The result is empty if the bag has no index. Raises OSError if the bag cannot be read.
        """
        topics: set[str] = set()
        try:
            stream.seek(len(MAGIC))
            start = int.from_bytes(
                _head(stream.read, self.size)[0].get(b"index_pos", b""), "little"
            )
            stream.seek(min(start or self.size, self.size))
            while stream.tell() < self.size:
                fields, length = _head(stream.read, self.size - stream.tell())
                data = stream.read(min(length, LARGEST_CHUNK))
                kind = _kind(fields)
                if kind == CONNECTION:
                    self._connect(fields, data)
                elif kind == CHUNK_INFO:
                    topics |= {
                        self._names[number]
                        for number, count in struct.iter_unpack("<II", data)
                        if count and number in self._names
                    }
        except (ValueError, struct.error):
            return set()
        return topics

    def _pieces(self, stream: BinaryIO) -> Iterator[tuple[TopicMessages | BagLoss, int]]:
        stream.seek(len(MAGIC))
        budget = UnpackedBudget(self.size)
        over = False  # True after the chunks, in the index of connections and chunks
        while (start := stream.tell()) < self.size:
            where = f"is damaged or cut off at byte {start} of {self.size}"
            try:
                fields, length = _head(stream.read, self.size - start)
                if length > LARGEST_CHUNK:
                    raise ValueError(
                        f"a record declares {length} bytes; allowed: at most {LARGEST_CHUNK}"
                    )
            except ValueError as error:
                yield BagLoss(f"{where}: {error}", {}), self.size
                return
            data = stream.read(min(length, self.size - stream.tell()))
            cut = len(data) < length
            kind = _kind(fields)
            try:
                if kind == CHUNK:
                    plain = _plain(fields, data, budget)
                    messages, end = self._grouped(plain)
                    whole = end == len(plain) == _number(fields, b"size") and not cut
                    yield (
                        messages
                        if whole
                        else BagLoss(
                            f"{where}: a chunk of {length} bytes cannot be read completely",
                            messages,
                        ),
                        stream.tell(),
                    )
                elif cut:
                    yield (
                        BagLoss(
                            f"{where}: a record declares {length} bytes, but {len(data)} remain",
                            {},
                        ),
                        self.size,
                    )
                elif kind == CONNECTION:
                    self._connect(fields, data)
                over |= kind == CHUNK_INFO
            except (ValueError, struct.error) as error:
                yield BagLoss(f"{where}: {error}", {}), stream.tell()
            if cut:
                return
        if not over:
            yield (
                BagLoss(f"is cut off at byte {self.size}: it has no list of chunks at its end", {}),
                self.size,
            )

    def _grouped(self, data: bytes) -> tuple[TopicMessages, int]:
        messages: TopicMessages = {}
        position = 0
        while position < len(data):
            try:
                fields, length, start = _record(data, position)
            except ValueError:
                break
            if start + length > len(data):
                break
            kind = _kind(fields)
            if not kind:
                break
            position = start + length
            if kind == CONNECTION:
                self._connect(fields, data[start:position])
            elif kind == MESSAGE:
                topic = self._names.get(_number(fields, b"conn"))
                if topic is None:
                    raise ValueError(
                        f"the connection {_number(fields, b'conn')} of a message is not declared"
                    )
                seconds, nanoseconds = _TIME.unpack(fields.get(b"time", b""))
                times, payloads = messages.setdefault(topic, ([], []))
                times.append(seconds * NS + nanoseconds)
                payloads.append(data[start:position])
        return messages, position

    def _connect(self, fields: Fields, data: bytes) -> None:
        about = _fields(data)
        name = fields.get(b"topic", about.get(b"topic", b"")).decode("utf-8", "replace")
        kind = about.get(b"type", b"").decode("utf-8", "replace")
        self._names[_number(fields, b"conn")] = name
        if name not in self.topics:
            self.topics[name] = topic_of(
                self._path, name, kind, "ros1", "ros1msg", about.get(b"message_definition", b"")
            )


def _head(read: Callable[[int], bytes], left: int) -> tuple[Fields, int]:
    raw = read(4)
    if len(raw) < 4:
        raise ValueError("a record is cut in its first bytes")
    (size,) = _U32.unpack(raw)
    most = min(left, LONGEST_HEADER)
    if size > most:
        raise ValueError(f"a header declares {size} bytes; allowed: at most {most}")
    fields = _fields(read(size))
    raw = read(4)
    if len(raw) < 4:
        raise ValueError("a record is cut off after its header")
    return fields, int(_U32.unpack(raw)[0])


def _record(data: bytes, position: int) -> tuple[Fields, int, int]:
    if position + 4 > len(data):
        raise ValueError("a record is cut in its first bytes")
    end = position + 4 + _U32.unpack_from(data, position)[0]
    if end + 4 > len(data):
        raise ValueError("a record is cut in its header")
    return _fields(data[position + 4 : end]), int(_U32.unpack_from(data, end)[0]), end + 4


def _fields(data: bytes) -> Fields:
    fields: Fields = {}
    position = 0
    while position < len(data):
        if position + 4 > len(data):
            raise ValueError("the fields of a header are cut")
        end = position + 4 + _U32.unpack_from(data, position)[0]
        name, equals, value = data[position + 4 : end].partition(b"=")
        if end > len(data) or not equals:
            raise ValueError("a header has a field without a name, or a field that is cut")
        fields[name] = value
        position = end
    return fields


def _kind(fields: Fields) -> int:
    return int.from_bytes(fields.get(b"op", b"")[:1], "little")


def _number(fields: Fields, name: bytes) -> int:
    value = fields.get(name, b"")
    if len(value) != 4:
        raise ValueError(f"a header has no field {name.decode()}")
    return int(_U32.unpack(value)[0])


def _plain(fields: Fields, data: bytes, budget: UnpackedBudget) -> bytes:
    size = _number(fields, b"size")
    compression = fields.get(b"compression", b"none")
    if size > LARGEST_CHUNK:
        raise ValueError(f"a chunk declares {size} bytes; allowed: at most {LARGEST_CHUNK}")
    if reason := budget.take(size):
        raise ValueError(reason)
    try:
        if compression == b"bz2":
            return bz2.BZ2Decompressor().decompress(data, size + 1)
        if compression == b"lz4":
            import lz4.frame

            plain: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
            return plain
    except (OSError, RuntimeError) as error:
        raise ValueError(f"a chunk cannot be decompressed ({error})") from None
    if compression != b"none":
        raise ValueError(f"unknown compression {compression!r}; allowed: none, bz2, lz4")
    return data
