"""Reader of the canonical log (mcap_layout.py) stream by stream, in bounded memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from frictool.errors import LogError
from frictool.logs.canonical.canonical_reader import CanonicalReader
from frictool.logs.canonical.mcap_bounds import whole_records
from frictool.logs.canonical.mcap_declarations import UNREADABLE, McapDeclarations, declared
from frictool.logs.canonical.mcap_layout import COLUMNS, MAGIC, NS, TIME, StreamHeader, message_path
from frictool.logs.canonical.mcap_losses import CanonicalLoss
from frictool.logs.canonical.mcap_metadata import epoch_ns, heads, notes, shift_ns
from frictool.logs.canonical.mcap_records import FileRecord, FileRecords
from frictool.logs.canonical.mcap_sections import contents
from frictool.logs.canonical.mcap_streams import ChannelSamples, axis_fields
from frictool.logs.losses import LossList
from frictool.logs.open_file import head_of, open_log
from frictool.logs.raw_table import DataLoss
from frictool.logs.stream_source import SampleBlock


def open_mcap(
    path: Path, salvage: bool = False
) -> tuple[list[CanonicalStream], dict[str, dict[str, str]], list[DataLoss]]:
    """Return the streams of a canonical log, its metadata records and its losses.

    The whole file is read and checked. Raises LogError if the file is missing, damaged or not
    canonical. If `salvage` is True, damage raises LogError only if nothing can be read.
    """
    lost: list[CanonicalLoss] | None = [] if salvage else None
    chunks: dict[int, set[int]] = {}
    with open_log(path) as stream:
        walk = CanonicalReader(path, stream, lost)
        for piece in checked_pieces(walk):
            chunks.setdefault(piece.channel, set()).update(piece.chunks)
    if salvage:
        walk.channels = {number: one for number, one in walk.channels.items() if one.samples}
    metadata = walk.metadata
    shift = shift_ns(path, metadata)
    epoch = epoch_ns(path, metadata)
    kept = notes(metadata)
    streams = []
    for number, head in zip(
        walk.channels, heads(path, metadata, walk.channels.values()), strict=True
    ):
        stored = {
            name: kept.get(COLUMNS, {}).get(message_path(head.topic, name))
            for name in ("time", *head.fields)
        }
        columns = {name: text for name, text in stored.items() if text is not None}
        clock = None if epoch is None else kept[TIME].get(head.topic, "unknown")
        streams.append(
            CanonicalStream(
                str(path),
                head,
                columns,
                number,
                frozenset(chunks[number]),
                shift,
                walk.size,
                epoch,
                clock,
            )
        )
    return streams, kept, [_loss(one, walk, shift) for one in lost or ()]


@dataclass
class CanonicalStream:
    """Stream of a canonical log that has been checked (implements StreamSource).

    chunks: byte offsets of the chunks with samples of the stream.
    shift: time in ns that the writer added to every time.
    epoch: clock time in ns at time 0 of the log; None if the log has no clock.
    """

    source: str
    head: StreamHeader
    columns: Mapping[str, str]
    number: int
    chunks: frozenset[int]
    shift: int
    size: int
    epoch: int | None = None
    clock: str | None = None
    done: int = 0
    losses: LossList = field(default_factory=LossList)
    warnings: tuple[str, ...] = ()

    def samples(self, salvage: bool = False) -> Iterator[SampleBlock]:
        """Yield the samples; their times are clock times if the log has a clock.

        Damaged data raises LogError if `salvage` is False, and is skipped if `salvage` is True.
        `open_mcap` has already recorded this damage.
        """
        path = Path(self.source)
        with open_log(path) as stream:
            walk = CanonicalReader(path, stream, [] if salvage else None, self.chunks)
            for piece in checked_pieces(walk):
                self.done = walk.done
                if piece.channel == self.number:
                    yield SampleBlock(
                        piece.samples.time + ((self.epoch or 0) - self.shift), piece.samples.values
                    )


def is_canonical(path: Path) -> bool:
    """Return True if the first channel of a file is a channel of a canonical log.

    The result is also True if an MCAP file has no channel or is damaged before the first channel.
    Raises LogError if the file cannot be read.
    """
    if not head_of(path).startswith(MAGIC[:5]):
        return False
    with open_log(path) as stream:
        declarations = McapDeclarations()
        try:
            for item, _ in contents(FileRecords(stream, path.stat().st_size)):
                inside = (
                    [(item.opcode, item.body)]
                    if isinstance(item, FileRecord)
                    else declared(item.data, whole_records(item.data)[0])
                )
                for opcode, body in inside:
                    channel = declarations.take(opcode, body)
                    if channel is not None:
                        return (
                            axis_fields(channel, declarations.schemas.get(channel.schema_id))
                            is not None
                        )
        except UNREADABLE:
            return True
        except OSError as error:
            raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    return True


def checked_pieces(walk: CanonicalReader) -> Iterator[ChannelSamples]:
    """Yield the samples of a reader; raise LogError if the file cannot be read."""
    try:
        yield from walk.pieces()
    except OSError as error:
        walk.fail(f"cannot be read: {error.strerror or error}")


def _loss(one: CanonicalLoss, walk: CanonicalReader, shift: int) -> DataLoss:
    of = (
        walk.channels.values() if one.channel not in walk.channels else [walk.channels[one.channel]]
    )
    paths = tuple(message_path(declared.topic, name) for declared in of for name in declared.fields)
    first, last = (None if at is None else (at - shift) / NS for at in (one.first, one.last))
    return DataLoss(paths, one.reason, first, last, one.samples)
