"""Reader of the canonical log (mcap_layout.py) in the order of the file, with every CRC checked.

A canonical log that another tool has rewritten can be read, too, if its messages are unchanged. The
chunks may be missing, have other sizes or contain several streams. The compression may be lz4 or
none, and the summary may be missing. An MCAP file with messages of another layout raises LogError.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NoReturn

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.canonical.mcap_bounds import record_bounds, whole_records
from frictool.logs.canonical.mcap_declarations import UNREADABLE, McapDeclarations, declared
from frictool.logs.canonical.mcap_layout import MESSAGE_OPCODE, NS, RECORD_HEAD, Records
from frictool.logs.canonical.mcap_losses import CanonicalLoss, MissingSamples
from frictool.logs.canonical.mcap_records import FileRecords
from frictool.logs.canonical.mcap_sections import FileSection, contents, error_text
from frictool.logs.canonical.mcap_streams import ChannelSamples, DeclaredStream, axis_fields
from frictool.logs.clocks.longest_increasing import increasing
from frictool.logs.raw_table import SALVAGE, Nanoseconds
from frictool.logs.stream_source import SampleBlock


class CanonicalReader:
    """Reader of one open canonical log.

    path: name of the file for messages.
    stream: the open file.
    lost: list to which each loss is appended; None if unreadable data raises LogError.
    only: byte offsets of the chunks to decompress; None for all chunks.
    """

    def __init__(
        self,
        path: Path,
        stream: BinaryIO,
        lost: list[CanonicalLoss] | None = None,
        only: frozenset[int] | None = None,
    ) -> None:
        self.path = path
        self.size = os.fstat(stream.fileno()).st_size
        self.done = 0
        self._only = only
        self._records = FileRecords(stream, self.size)
        self._declarations = McapDeclarations()
        self.channels: dict[int, DeclaredStream] = {}
        self._missing = None if lost is None else MissingSamples(lost)

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records read so far, by name."""
        return self._declarations.metadata

    def fail(self, message: str) -> NoReturn:
        """Raise LogError with this message about the log's file."""
        raise LogError(self.path, message)

    def pieces(self) -> Iterator[ChannelSamples]:
        """Yield the samples of all channels in the order of the file.

        Raises LogError if the file is damaged or not a canonical log, and OSError if the operating
        system cannot read the file.
        """
        over = False  # True after the data section: no sample follows
        for item, done in contents(self._records, self._only):
            self.done = done
            if isinstance(item, FileSection):
                yield from self._part(item)
                continue
            over |= item.opcode == Opcode.DATA_END
            try:
                self._declaration(item.opcode, item.body)
            except UNREADABLE as error:
                self._lose(
                    FileSection(
                        item.offset,
                        reason=f"record {item.opcode:#04x} cannot be decoded ({error_text(error)})",
                        empty=over,
                    )
                )
        if self._only is None:
            self._check_counts()

    def _part(self, part: FileSection) -> Iterator[ChannelSamples]:
        alike = self._of_one_channel(part) if part.whole else None
        if alike is not None:
            yield alike
        elif part.joined:
            for one in part.joined:
                yield from self._part(one)
        else:
            if part.data and not (part.reason and self._missing is None):
                try:
                    yield from self._mixed(part)
                except UNREADABLE as error:
                    part.reason = part.reason or f"a chunk cannot be read ({error_text(error)})"
            if part.reason:
                self._lose(part)

    def _lose(self, part: FileSection) -> None:
        last = max(
            (one.last for one in self.channels.values() if one.last is not None), default=None
        )
        if self._missing is not None:
            self._missing.unread(part, last, self.size)
            return
        after = "before any sample" if last is None else f"after {last / NS:.6g} s of log"
        advice = (
            SALVAGE
            if last is not None or self._has_more()
            else "copy the file again from the recorder"
        )
        self.fail(
            f"is damaged or cut off at byte {part.at} of {self.size}, {after}: {part.reason}; "
            f"{advice}"
        )

    def _has_more(self) -> bool:
        with self.path.open("rb") as stream:
            try:
                return any(
                    piece.samples.time.size
                    for piece in CanonicalReader(self.path, stream, []).pieces()
                )
            except (LogError, OSError):
                return False

    def _declaration(self, opcode: int, body: bytes) -> None:
        channel = self._declarations.take(opcode, body)
        if channel is not None:
            self._channel(channel)

    def _channel(self, channel: Channel) -> None:
        schema = self._declarations.schemas.get(channel.schema_id)
        fields = axis_fields(channel, schema)
        if fields is None:
            kind = schema.name if schema is not None else "no schema"
            self.fail(
                f"is not a canonical log: channel {channel.topic!r} contains {kind} in "
                f"{channel.message_encoding or 'no encoding'}; allowed: /axis and /axis/NAME with "
                "flat float64 fields in cdr (`frictool ingest` writes them)"
            )
        known = self.channels.setdefault(
            channel.id, DeclaredStream(channel.id, channel.topic, fields)
        )
        if (known.topic, known.fields) != (channel.topic, fields):
            raise ValueError(
                f"channel {channel.id} is declared twice, as {known.topic} and as {channel.topic}"
            )

    def _of_one_channel(self, part: FileSection) -> ChannelSamples | None:
        data = part.data
        if len(data) <= RECORD_HEAD + 2 or data[0] != MESSAGE_OPCODE:
            return None
        channel = self.channels.get(int.from_bytes(data[RECORD_HEAD : RECORD_HEAD + 2], "little"))
        if channel is None or len(data) % channel.dtype.itemsize:
            return None
        records = np.frombuffer(data, channel.dtype)
        if not channel.are_mine(records):
            return None
        time, values = _columns(records)
        late = channel.last is None or time[0] > channel.last
        if not (late and (time[1:] > time[:-1]).all() and np.isfinite(values).all()):
            return None
        return self._kept(channel, time, values, part)

    def _mixed(self, part: FileSection) -> Iterator[ChannelSamples]:
        """Yield the samples of a section that contains invalid messages or several channels.

        An invalid message in a complete chunk raises ValueError. An invalid message in any other
        section is recorded as damage.
        """
        data = part.data
        bounds = record_bounds(data) if part.whole else whole_records(data)[0]
        for opcode, body in declared(data, bounds):
            self._declaration(opcode, body)
        mine = (bounds.opcode == MESSAGE_OPCODE) & (bounds.length >= 2)
        starts = bounds.start[mine] - RECORD_HEAD
        sizes = bounds.length[mine] + RECORD_HEAD
        plain = np.frombuffer(data, np.uint8)
        numbers = (
            plain[starts + RECORD_HEAD] + plain[starts + RECORD_HEAD + 1].astype(np.int64) * 256
        )
        for number in dict.fromkeys(numbers.tolist()):
            channel = self.channels.get(number)
            which = numbers == number
            fits = which if channel is None else which & (sizes == channel.dtype.itemsize)
            if channel is not None and fits.any():
                records = (
                    plain[starts[fits][:, None] + np.arange(channel.dtype.itemsize)]
                    .reshape(-1)
                    .view(channel.dtype)
                )
                if channel.are_mine(records):
                    yield from self._taken(channel, records, part)
                    which &= ~fits
            if which.any():
                wrong = f"{int(which.sum())} messages of channel {number} do not match its schema"
                if part.whole:
                    raise ValueError(wrong)
                self._lose(FileSection(part.at, reason=wrong))

    def _taken(
        self, channel: DeclaredStream, records: Records, part: FileSection
    ) -> Iterator[ChannelSamples]:
        time, values = _columns(records)
        if not np.isfinite(values).all():
            good = np.logical_and.reduce(np.isfinite(values))
            row = int(np.argmin(good))
            name = channel.fields[int(np.argmin(np.isfinite(values[:, row])))]
            self._unfit(channel, f"{name} is not finite", row, time, good)
            time = time[good]
            values = values[:, good]
        back = time[1:] <= time[:-1]
        if back.any() or (time.size and channel.last is not None and time[0] <= channel.last):
            row = int(np.argmax(back)) + 1 if back.any() else 0
            kept = increasing(time, channel.last)
            self._unfit(
                channel, "time does not increase", row, time, np.isin(np.arange(time.size), kept)
            )
            time = time[kept]
            values = values[:, kept]
        if time.size:
            yield self._kept(channel, time, values, part)

    def _kept(
        self,
        channel: DeclaredStream,
        time: Nanoseconds,
        values: NDArray[np.float64],
        part: FileSection,
    ) -> ChannelSamples:
        if self._missing is not None:
            self._missing.until(int(time[0]))
        channel.samples = channel.samples + int(time.size)
        channel.last = int(time[-1])
        return ChannelSamples(
            channel.number,
            SampleBlock(time, tuple(values)),
            tuple(one.at for one in part.joined or (part,)),
        )

    def _unfit(
        self,
        channel: DeclaredStream,
        what: str,
        row: int,
        time: Nanoseconds,
        good: NDArray[np.bool_],
    ) -> None:
        if self._missing is None:
            self.fail(
                f"stream {channel.topic}: {what} at sample {channel.samples + row + 1}, "
                f"{time[row] / NS:.9g} s"
            )
        bad = time[~good]
        self._missing.lost.append(
            CanonicalLoss(what, channel.number, int(bad.min()), int(bad.max()), int(bad.size))
        )

    def _check_counts(self) -> None:
        counts = self._declarations.counts or {}
        samples = {
            number: self.channels[number].samples if number in self.channels else 0
            for number in counts
        }
        if self._missing is not None:
            self._missing.check(counts, samples)
            return
        for number, count in counts.items():
            if count != samples[number]:
                name = (
                    self.channels[number].topic if number in self.channels else f"channel {number}"
                )
                self.fail(
                    f"is damaged: {samples[number]} messages of {name} are present, but the "
                    f"statistics count {count}"
                )


def _columns(records: Records) -> tuple[Nanoseconds, NDArray[np.float64]]:
    return records["log_time"].astype(np.int64), np.ascontiguousarray(records["values"].T)
