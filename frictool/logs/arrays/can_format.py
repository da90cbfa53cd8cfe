"""Reader of CAN logs (BLF, ASC, candump, PCAN-Trace), with python-can and cantools.

A DBC file in the folder of the log defines the signals in the frames. The key `layout.dbc` in
bench.yaml gives the name of the DBC file; the default is the name of the log with the suffix
`.dbc`. Each message of the DBC becomes a table with the times of its frames.

    frames ──python-can──▶ (time, identifier, bytes) ──cantools, DBC──▶ signals of each message
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.open_file import open_log
from frictool.logs.optional_libraries import library
from frictool.logs.raw_table import BLOCK_ROWS, SALVAGE, DataLoss, RawTable, RowBlock
from frictool.logs.text.header_units import is_unit, spelled

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

# class of python-can that reads a format, and pattern of the first bytes of files in this format
READERS = (
    ("BLFReader", re.compile(rb"LOGG")),
    ("ASCReader", re.compile(rb"(?:\s*//.*\s+)*date\s+\w+.*\s+base\s+(?:hex|dec)\b")),
    ("CanutilsLogReader", re.compile(rb"\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#")),
    # PCAN-Trace; files of version 1.0 do not state their version
    ("TRCReader", re.compile(rb";(?:\$FILEVERSION=|#+\s*\n(?:;.*\n)*?;\s+Start time: )")),
)
FRAMES = 100_000  # number of frames that are read to list the messages of a log
CUT = "the file is cut off: its header declares {} bytes, but it has {}"
NO_LINE_END = "the last line has no line end: the file may be cut off"


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins like a CAN log."""
    return _reader_of(head) is not None


def _reader_of(head: bytes) -> str | None:
    return next((name for name, pattern in READERS if pattern.match(head)), None)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table for each message that the DBC defines and the first FRAMES frames contain.

    Raises LogError if the DBC is missing or damaged, or defines none of these frames.
    """
    with open_log(path) as stream:
        reader = _reader_of(stream.read(4096))
    library(path, "cantools", "can")
    named = None if layout is None else layout.dbc
    dbc = path.parent / named if named else path.with_suffix(".dbc")
    if not dbc.is_file():
        raise LogError(
            path,
            f"needs a DBC file for its frames, but found no {dbc.name} in its folder; write "
            "layout.dbc: FILE in bench.yaml, or rename the DBC file",
        )
    return open_guarded(path, partial(_open, dbc=dbc, reader=str(reader)))


@dataclass(kw_only=True)
class MessageTable(LibraryTable):
    """Table of the frames of one CAN message.

    message: definition of the message in the DBC, an object of cantools.
    identifier: (number, is_extended) of the frames; is_extended is True for an identifier of 29
        bits.
    reader: name of the class of python-can that reads the file.
    """

    message: Any
    identifier: tuple[int, bool]
    reader: str

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows, one row for each frame (see RawTable.blocks).

        A frame that contains none of the requested signals gives no row.
        """
        path = Path(self.source)
        frames = (
            frame
            for frame in _frames(path, self.reader, losses)
            if (frame.arbitration_id, frame.is_extended_id) == self.identifier
        )
        first = 0
        while part := list(islice(frames, BLOCK_ROWS)):
            rows = []
            times = []
            for frame in part:
                signals = self._signals(frame, losses)
                if signals is not None and any(name in signals for name in wanted):
                    rows.append([float(signals.get(name, np.nan)) for name in wanted])
                    times.append(round(1e9 * frame.timestamp))
            if rows:
                values = np.array(rows)
                yield (
                    RowBlock(
                        first,
                        {name: values[:, k].copy() for k, name in enumerate(wanted)},
                        np.array(times, np.int64),
                    ),
                    self.size,
                )
                first += len(rows)

    def _signals(self, frame: Any, losses: list[DataLoss] | None) -> dict[str, Any] | None:
        try:
            decoded: dict[str, Any] = self.message.decode(frame.data, decode_choices=False)
        except Exception as error:  # cantools raises errors of many types
            reason = f"frame at {frame.timestamp:.6f} s of {self.message.name!r}: {error}"
            if losses is None:
                raise LogError(self.source, f"{reason}; {SALVAGE}") from None
            losses.append(DataLoss((), reason, samples=1))
            return None
        return decoded


def _open(path: Path, dbc: Path, reader: str) -> Sequence[LibraryTable]:
    import cantools

    try:
        database: Any = cantools.database.load_file(str(dbc), database_format="dbc")
    except Exception as error:  # cantools raises errors of many types
        raise LogError(
            dbc, f"is not a DBC, or is damaged: {' '.join(str(error).split())}"
        ) from None
    found = Counter(
        (frame.arbitration_id, frame.is_extended_id)
        for frame in islice(_frames(path, reader, []), FRAMES)
    )
    described = {(one.frame_id, one.is_extended_frame): one for one in database.messages}
    tables = [
        MessageTable(
            source=str(path),
            topic=described[identifier].name,
            columns={signal.name: signal for signal in described[identifier].signals},
            units={signal.name: _unit(signal) for signal in described[identifier].signals},
            others={},
            clock="log time",
            message=described[identifier],
            identifier=identifier,
            reader=reader,
        )
        for identifier in found
        if identifier in described
    ]
    if not tables:
        identifiers = [f"{number:X}" for number, _ in sorted(found)]
        raise LogError(
            path,
            f"has no frame that {dbc.name} describes; found "
            + (f"the identifiers {listed(identifiers)}" if identifiers else "no data frame"),
        )
    return tables


def _unit(signal: Any) -> str | None:
    return spelled(signal.unit) if signal.unit and is_unit(signal.unit) else None


def _frames(path: Path, reader: str, losses: list[DataLoss] | None) -> Iterator[Any]:
    import can

    damage = _cut(path, reader)
    count = 0
    try:
        with getattr(can, reader)(str(path)) as frames:
            if reader == "BLFReader" and frames.file_size > path.stat().st_size:
                damage = CUT.format(frames.file_size, path.stat().st_size)
            for frame in frames:
                count += 1
                if not frame.is_error_frame and not frame.is_remote_frame:
                    yield frame
    except LogError:
        raise
    except Exception as error:  # python-can raises errors of many types
        damage = f"{' '.join(str(error).split()) or type(error).__name__} (after {count} frames)"
    if damage is not None:
        if losses is None:
            raise LogError(path, f"is damaged: {damage}; {SALVAGE}")
        losses.append(DataLoss((), damage))


def _cut(path: Path, reader: str) -> str | None:
    if reader == "BLFReader":
        return None
    with path.open("rb") as stream:
        stream.seek(-1, 2)
        return None if stream.read() in (b"\n", b"\r") else NO_LINE_END
