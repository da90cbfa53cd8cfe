r"""Reader of ASAM MDF files (versions 2 to 4), with asammdf (extra `mdf`).

Each channel group is a table; its master channel gives the times of the rows. The name of a column
is the name of the channel in the file, such as `nAct\ETKC:1`. If several groups have a channel of
this name, `GROUP/NAME` selects one. Values are physical values. If the conversion of a channel
gives texts, the raw numbers of this channel are used instead. A sample that is marked as invalid
raises LogError; with `--salvage`, the sample becomes an empty cell.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.arrays.truncated_mdf import ZeroPaddedFile, described_at, records_before
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import (
    BLOCK_ROWS,
    SALVAGE,
    DataLoss,
    Nanoseconds,
    RawTable,
    RowBlock,
)
from frictool.typing import Vector

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

# signature of a complete file, and of a file whose logger was switched off while it was writing
MAGIC = (b"MDF     ", b"UnFinMF ")
TO_TEXT = {4: (7, 8), 3: (11, 12), 2: (11, 12)}  # version -> codes of conversions to texts
# sync type of a master channel of version 4 that holds time (others: angle, distance, index)
TIME = 1
LATEST = 9e9  # s, latest time that int64 ns can express, rounded down


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins with the signature of MDF."""
    return head.startswith(MAGIC)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table for each channel group with samples and numeric channels.

    Raises LogError if no group has numbers, or if the file is damaged.
    """
    open_log(path).close()
    return open_guarded(path, _open)


def _open(path: Path) -> Sequence[LibraryTable]:
    from asammdf import MDF

    logging.disable(logging.CRITICAL)
    try:
        file = MDF(path.open("rb"))
        end = None
    except Exception:  # asammdf raises errors of many types
        try:
            file = MDF(ZeroPaddedFile(path))
            end = path.stat().st_size
        except Exception:
            raise LogError(path, _unreadable(path)) from None
    version = int(file.version[0])
    start = (
        int(file.header.abs_time)
        if version == 4
        else int(file.start_time.timestamp()) * 1_000_000_000
    )
    groups: Sequence[Any] = file.groups
    named = [
        (index, _group_name(index, group))
        for index, group in enumerate(groups)
        if group.channel_group.cycles_nr
    ]
    count = Counter(name for _, name in named)
    opened = [
        _group(path, file, index, name if count[name] == 1 else f"{name} {index + 1}", start, end)
        for index, name in named
    ]
    if not any(table.names for table in opened):
        # asammdf may read the zeros after the end as a file without channels
        if described_at(path) is not None:
            raise LogError(path, _unreadable(path))
        empty = [f"{name} ({what})" for table in opened for name, what in table.others.items()]
        raise LogError(
            path, f"has no numeric channel that contains samples; found: {listed(empty)}"
        )
    return [table for table in opened if table.names]


def _unreadable(path: Path) -> str:
    behind = described_at(path)
    if behind is None:
        return (
            "is damaged, or a kind of MDF that frictool cannot read: its blocks are inconsistent; "
            "export it again, or as CSV"
        )
    end = path.stat().st_size
    return (
        f"is cut off at byte {end}, before the description of its channels at byte {behind}, so "
        "that nothing can be salvaged; copy or export it again"
    )


def _group_name(index: int, group: Any) -> str:
    return getattr(group.channel_group, "acq_name", "") or f"group {index + 1}"


def _group(path: Path, file: Any, index: int, topic: str, start: int, end: int | None) -> MdfTable:
    version = int(file.version[0])
    group: Any = file.groups[index]
    count = Counter(channel.name for channel in group.channels)
    master = file.masters_db.get(index)
    columns = {}
    units = {}
    others = {}
    for number, channel in enumerate(group.channels):
        name = (
            channel.name if count[channel.name] == 1 else f"{channel.name} (channel {number + 1})"
        )
        conversion = getattr(channel.conversion, "conversion_type", None)
        raw = conversion in TO_TEXT[version]
        sample, _ = file.get(
            group=index,
            index=number,
            samples_only=True,
            raw=raw,
            ignore_invalidation_bits=True,
            record_count=1,
        )
        if sample.dtype.kind in "iufb" and sample.ndim == 1:
            columns[name] = MdfChannel(number, raw)
            units[name] = (
                None if raw else file.get_channel_unit(group=index, index=number).strip() or None
            )
        else:
            others[name] = (
                "an array" if sample.ndim > 1 or sample.dtype.names else "a text, not a number"
            )
    is_time = master is not None and (version < 4 or group.channels[master].sync_type == TIME)
    clock = (
        next((name for name, channel in columns.items() if channel.index == master), None)
        if is_time
        else None
    )
    whole = None if end is None else records_before(group, end)
    return MdfTable(
        source=str(path),
        topic=topic,
        columns=columns,
        units=units,
        others=others,
        clock=clock,
        file=file,
        group=index,
        start=start,
        whole=whole,
    )


@dataclass(frozen=True)
class MdfChannel:
    """Channel of a channel group.

    raw: True if the conversion gives texts, so that the raw numbers are used.
    """

    index: int
    raw: bool


@dataclass(kw_only=True)
class MdfTable(LibraryTable):
    """Table of a channel group of an open file.

    file: open file, an object of asammdf.
    group: index of the channel group.
    start: start time of the file in ns since 1970-01-01.
    whole: number of complete records in a truncated file; None if the file is complete.
    """

    file: Any
    group: int
    start: int
    whole: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.rows = int(self.file.groups[self.group].channel_group.cycles_nr)

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks) until a block cannot be decoded."""
        readable = self.rows if self.whole is None else self.whole
        cut = f"the file is cut off; group {self.topic!r} has {readable} of {self.rows} samples"
        if self.whole is not None and losses is None:
            raise LogError(self.source, cut)
        for first in range(0, readable, BLOCK_ROWS):
            n = min(BLOCK_ROWS, readable - first)
            try:
                columns = {name: self._read(name, first, n, losses) for name in wanted}
                time = None if self.clock is None else self._stamps(first, n)
            except LogError:
                raise
            except Exception as error:  # asammdf raises errors of many types
                reason = (
                    f"group {self.topic!r} is damaged or cut off: "
                    f"{str(error) or type(error).__name__}"
                )
                if losses is None:
                    raise LogError(
                        self.source, f"{reason}; {first} samples were read before; {SALVAGE}"
                    ) from None
                losses.append(DataLoss((), reason, samples=self.rows - first))
                return
            yield RowBlock(first, columns, time), self.size * (first + n) // self.rows
        if self.whole is not None and losses is not None:
            losses.append(DataLoss((), cut, samples=self.rows - readable))

    def _read(self, name: str, first: int, n: int, losses: list[DataLoss] | None) -> Vector:
        values, invalid = self._samples(name, first, n)
        if invalid is None or not invalid.any():
            return values
        if losses is None:
            row = first + int(np.flatnonzero(invalid)[0])
            damage = (
                f"group {self.topic!r}, channel {name!r}: sample {row + 1} is marked as invalid"
            )
            raise LogError(self.source, f"{damage}; {SALVAGE}")
        return np.where(invalid, np.nan, values)

    def _samples(self, name: str, first: int, n: int) -> tuple[Vector, NDArray[np.bool_] | None]:
        channel = self.columns[name]
        values, invalid = self.file.get(
            group=self.group,
            index=channel.index,
            samples_only=True,
            raw=channel.raw,
            ignore_invalidation_bits=True,
            record_offset=first,
            record_count=n,
        )
        if values.shape != (n,):
            raise ValueError(f"only {len(values)} of {n} samples are present")
        return values.astype(np.float64), invalid

    def _stamps(self, first: int, n: int) -> Nanoseconds:
        seconds, _ = self._samples(str(self.clock), first, n)
        if not np.isfinite(seconds).all() or np.abs(seconds).max() > LATEST:
            raise ValueError(
                f"the times of the samples {first + 1} to {first + n} are not all finite and below "
                f"{LATEST:g} s"
            )
        stamps: Nanoseconds = self.start + np.rint(seconds * 1e9).astype(np.int64)
        return stamps
