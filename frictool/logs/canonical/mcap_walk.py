"""The canonical log (mcap_layout.py) in the order of its file: declarations are gathered, samples are given, and every CRC is checked.

What another tool made of a canonical log is read as well, as long as the messages are the same: other chunks, several streams in one
chunk, lz4 or no compression, no chunks, no summary. An MCAP with other messages is refused.
"""

from __future__ import annotations

import io
import os
import re
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NoReturn

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema, Statistics
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.canonical.mcap_chunk import chunk_data, chunk_prefix
from frictool.logs.canonical.mcap_layout import (
    EPOCH_KEY,
    MESSAGE_OPCODE,
    NS,
    RECORD_HEAD,
    SHIFT_KEY,
    TIME,
    UNITS,
    Head,
    Records,
    message_path,
)
from frictool.logs.canonical.mcap_records import Damage, FileRecords, Loose, Record, record_bounds, whole_records
from frictool.logs.canonical.mcap_streams import Declared, Lost, Piece, axis_fields
from frictool.logs.clocks.increasing import increasing
from frictool.logs.flow import Samples
from frictool.logs.table import Nanoseconds

_INDEX = struct.Struct("<HI")  # channel, bytes of entries
_WHOLE = re.compile(r"-?[0-9]{1,19}")
_UNREADABLE = (McapError, struct.error, ValueError)


class Walk:
    """The way through one open file.

    Args:
        path: for messages.
        stream: the file.
        lost: what cannot be read is appended to it and left out; None raises LogError.
        only: bytes where chunks begin that are opened; None opens all.
    """

    def __init__(self, path: Path, stream: BinaryIO, lost: list[Lost] | None = None, only: frozenset[int] | None = None) -> None:
        self.path, self.size, self.lost, self._only = path, os.fstat(stream.fileno()).st_size, lost, only
        self.records = FileRecords(stream, self.size)
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Declared] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.counts: dict[int, int] | None = None  # by the statistics
        self._unread: Lost | None = None  # the indexes behind a chunk tell what was in it,
        self._told = False  # where they are there
        self._over = False  # no sample follows
        self._endless: list[int] = []  # the place in `lost` without an end, where there is one

    def fail(self, message: str) -> NoReturn:
        raise LogError(self.path, message)

    def pieces(self) -> Iterator[Piece]:
        """The samples. Raises LogError where the file is damaged or no canonical log, and OSError."""
        for item in self.records:
            if isinstance(item, Loose):
                self._close_unread()
                yield from self._mixed(item.data, item.offset, loose=True)
            else:
                yield from self._damage(item) if isinstance(item, Damage) else self._record(item)
        self._close_unread()
        if self._only is None:
            self._check_counts()

    def _record(self, item: Record) -> Iterator[Piece]:
        if item.opcode == Opcode.MESSAGE_INDEX and self._unread is not None:
            self._indexed(item.body)
            return
        self._close_unread()
        self._over |= item.opcode == Opcode.DATA_END
        if item.opcode == Opcode.CHUNK:
            yield from self._chunk(item)
            return
        try:
            self._declaration(item.opcode, item.body)
        except _UNREADABLE as error:
            self._lose(f"record {item.opcode:#04x} cannot be decoded ({_said(error)})", item.offset)

    def _chunk(self, item: Record) -> Iterator[Piece]:
        if self._only is not None and item.offset not in self._only:
            return
        try:
            yield from self._messages(chunk_data(item.body), item.offset)
        except _UNREADABLE as error:
            self._lose(f"a chunk cannot be read ({_said(error)})", item.offset)

    def _damage(self, item: Damage) -> Iterator[Piece]:
        self._close_unread()
        if self.lost and "CRC" in item.reason:  # of the whole section, in which damage has been found already
            return
        if item.rest and self.lost is not None:
            with suppress(*_UNREADABLE):
                yield from self._mixed(chunk_prefix(item.rest), item.start, loose=True)
        self._lose(item.reason, item.start, item.bare)

    def _lose(self, reason: str, at: int, bare: bool = False) -> None:
        """Notes that something cannot be read, `bare` where no sample is in it. Raises LogError where nothing may be lost."""
        last = max((one.last for one in self.channels.values() if one.last is not None), default=None)
        if self.lost is None:
            after = "before any sample" if last is None else f"after {last / NS:.6g} s of log"
            hint = "`frictool ingest --salvage` keeps what is whole"
            self.fail(f"is damaged or cut off at byte {at} of {self.size}, {after}: {reason}; {hint}")
        reason = f"{reason}, at byte {at} of {self.size}"
        self._unread = Lost(reason, samples=0) if self._over or bare else Lost(reason, first=last)

    def _indexed(self, body: bytes) -> None:
        """The index of one channel behind a chunk that cannot be read: when, and how many samples."""
        assert self._unread is not None
        assert self.lost is not None
        if len(body) < _INDEX.size:
            return
        channel, size = _INDEX.unpack_from(body)
        times = np.frombuffer(body, "<u8", offset=_INDEX.size)[::2].astype(np.int64) if size and size == len(body) - _INDEX.size else None
        if times is not None:
            self.lost.append(Lost(self._unread.reason, channel, int(times.min()), int(times.max()), int(times.size)))
            self._told = True

    def _close_unread(self) -> None:
        """What cannot be read and has no index: it ends where the next sample is."""
        if self._unread is not None and self.lost is not None and not self._told:
            if self._unread.samples is not None:
                self.lost.append(self._unread)
            elif not self._endless:  # else the interruption has been told already
                self._endless.append(len(self.lost))
                self.lost.append(self._unread)
        self._unread, self._told = None, False

    def _declaration(self, opcode: int, body: bytes) -> None:
        """Takes in a record that holds no samples; kinds that say nothing of them are skipped."""
        stream = ReadDataStream(io.BytesIO(body))
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            self.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._channel(Channel.read(stream))
        elif opcode == Opcode.METADATA:
            metadata = Metadata.read(stream)
            self.metadata[metadata.name] = metadata.metadata
        elif opcode == Opcode.STATISTICS:
            self.counts = dict(Statistics.read(stream).channel_message_counts)

    def _channel(self, channel: Channel) -> None:
        """Declares a stream. Raises LogError where it is none of a canonical log."""
        schema = self.schemas.get(channel.schema_id)
        fields = axis_fields(channel, schema)
        if fields is None:
            kind = schema.name if schema is not None else "no schema"
            self.fail(
                f"is no canonical log: channel {channel.topic!r} carries {kind} in {channel.message_encoding or 'no encoding'}; "
                "allowed: /axis and /axis/NAME with flat float64 fields in cdr, as `frictool ingest` and `simulate` write them"
            )
        known = self.channels.setdefault(channel.id, Declared(channel.id, channel.topic, fields))
        if (known.topic, known.fields) != (channel.topic, fields):
            raise ValueError(f"channel {channel.id} is declared twice, as {known.topic} and as {channel.topic}")

    def _messages(self, data: bytes, at: int) -> Iterator[Piece]:
        """Message records, as they stand in a chunk: usually of one channel and nothing else. Raises ValueError."""
        if len(data) > RECORD_HEAD + 2 and data[0] == MESSAGE_OPCODE:
            channel = self.channels.get(int.from_bytes(data[RECORD_HEAD : RECORD_HEAD + 2], "little"))
            if channel is not None and len(data) % channel.dtype.itemsize == 0:
                records = np.frombuffer(data, channel.dtype)
                if channel.are_mine(records):
                    yield from self._taken(channel, records, at)
                    return
        yield from self._mixed(data, at)

    def _mixed(self, data: bytes, at: int, loose: bool = False) -> Iterator[Piece]:
        """The same for what another tool has put together.

        loose: it is no chunk that is whole, so that what does not fit is damage by itself. Otherwise raises ValueError.
        """
        bounds = whole_records(data)[0] if loose else record_bounds(data)
        for place in np.flatnonzero(bounds.opcode != MESSAGE_OPCODE).tolist():
            opcode, start = int(bounds.opcode[place]), int(bounds.start[place])
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):  # a chunk holds nothing else, and above all no chunk
                self._declaration(opcode, data[start : start + int(bounds.length[place])])
        mine = (bounds.opcode == MESSAGE_OPCODE) & (bounds.length >= 2)
        starts, sizes = bounds.start[mine] - RECORD_HEAD, bounds.length[mine] + RECORD_HEAD
        plain = np.frombuffer(data, np.uint8)
        numbers = plain[starts + RECORD_HEAD] + plain[starts + RECORD_HEAD + 1].astype(np.int64) * 256
        for number in dict.fromkeys(numbers.tolist()):
            channel, which = self.channels.get(number), numbers == number
            fits = which if channel is None else which & (sizes == channel.dtype.itemsize)
            if channel is not None and fits.any():
                records = plain[starts[fits][:, None] + np.arange(channel.dtype.itemsize)].reshape(-1).view(channel.dtype)
                if channel.are_mine(records):
                    yield from self._taken(channel, records, at)
                    which &= ~fits
            if which.any():
                wrong = f"{int(which.sum())} messages of channel {number} are not as its schema says"
                if not loose:
                    raise ValueError(wrong)
                self._lose(wrong, at)
                self._close_unread()

    def _taken(self, channel: Declared, records: Records, at: int) -> Iterator[Piece]:
        """Samples of one channel: finite, and in the order of time."""
        time, values = records["log_time"].astype(np.int64), np.ascontiguousarray(records["values"].T)
        if not np.isfinite(values).all():
            good = np.isfinite(values).all(axis=0)
            row = int(np.argmin(good))
            name = channel.fields[int(np.argmin(np.isfinite(values[:, row])))]
            self._unfit(channel, f"{name} is not finite", row, time, good)
            time, values = time[good], values[:, good]
        back = np.diff(time) <= 0
        if back.any() or (time.size and channel.last is not None and time[0] <= channel.last):
            row = int(np.argmax(back)) + 1 if back.any() else 0
            kept = increasing(time, channel.last)
            self._unfit(channel, "time does not increase", row, time, np.isin(np.arange(time.size), kept))
            time, values = time[kept], values[:, kept]
        if time.size:
            self._end(int(time[0]))
            channel.first = int(time[0]) if channel.first is None else channel.first
            channel.samples, channel.last = channel.samples + int(time.size), int(time[-1])
            yield Piece(channel.number, Samples(time, tuple(values)), at)

    def _end(self, time: int) -> None:
        for place in self._endless:
            assert self.lost is not None
            self.lost[place] = self.lost[place]._replace(last=time)
        self._endless.clear()

    def _unfit(self, channel: Declared, what: str, row: int, time: Nanoseconds, good: NDArray[np.bool_]) -> None:
        """Samples that are left out, although they can be read. Raises LogError where nothing may be lost."""
        if self.lost is None:
            self.fail(f"stream {channel.topic}: {what} at sample {channel.samples + row + 1}, {time[row] / NS:.9g} s")
        bad = time[~good]
        self.lost.append(Lost(what, channel.number, int(bad.min()), int(bad.max()), int(bad.size)))

    def _check_counts(self) -> None:
        """Compares with the statistics, which may tell how much was lost. Raises LogError where they count otherwise."""
        missing = {}
        for number, declared in (self.counts or {}).items():
            found = self.channels[number].samples if number in self.channels else 0
            if declared != found and self.lost is None:
                name = self.channels[number].topic if number in self.channels else f"channel {number}"
                self.fail(f"is damaged: {found} messages of {name} are there, the statistics count {declared}")
            missing[number] = declared - found - sum(one.samples or 0 for one in self.lost or () if one.channel == number)
        if self.lost is not None and any(count > 0 for count in missing.values()):
            self._count(self.lost, {number: count for number, count in missing.items() if count > 0})

    @staticmethod
    def _count(lost: list[Lost], missing: dict[int, int]) -> None:
        """Puts numbers to what was lost: to the one loss that has none, else to all of them together."""
        unknown = [one for one in lost if one.samples is None]
        if len(unknown) == 1:
            lost.remove(unknown[0])
            lost += [unknown[0]._replace(channel=number, samples=count) for number, count in missing.items()]
        else:
            lost += [Lost("the statistics count so many more than are there", number, samples=count) for number, count in missing.items()]

    def heads(self) -> list[Head]:
        """The streams in the order of their channels. Raises LogError where there is none, or one has no samples or no units."""
        if not self.channels:
            self.fail("is no canonical log: it has no channel")
        units = self.metadata.get(UNITS, {})
        for one in self.channels.values():
            if not one.samples:
                self.fail(f"stream {one.topic} has no samples")
            missing = [name for name in one.fields if message_path(one.topic, name) not in units]
            if missing:
                self.fail(f"is no canonical log: metadata {UNITS!r} has no {message_path(one.topic, missing[0])!r}")
        return [
            Head(one.topic, one.fields, tuple(units[message_path(one.topic, name)] for name in one.fields))
            for one in self.channels.values()
        ]

    def shift(self) -> int:
        """What was added to every time, in ns. Raises LogError where it is no number."""
        return self._nanoseconds(SHIFT_KEY) or 0

    def epoch(self) -> int | None:
        """What the clocks showed at 0 of the log, in ns; None where none dates it. Raises LogError where it is no number."""
        return self._nanoseconds(EPOCH_KEY)

    def _nanoseconds(self, key: str) -> int | None:
        text = self.metadata.get(TIME, {}).get(key)
        if text is not None and not (_WHOLE.fullmatch(text) and abs(int(text)) < 2**62):
            self.fail(f"metadata {TIME}.{key}: found {text!r}; allowed: a whole number")
        return None if text is None else int(text)

    def notes(self) -> dict[str, dict[str, str]]:
        """The metadata records, without what the streams carry."""
        clocks = {key: text for key, text in self.metadata.get(TIME, {}).items() if key != SHIFT_KEY}
        others = {name: entries for name, entries in self.metadata.items() if name not in (UNITS, TIME)}
        return {**others, **({TIME: clocks} if clocks else {})}


def _said(error: Exception) -> str:
    return str(error) or type(error).__name__
