"""Reader of TDMS, the binary files of LabVIEW and DIAdem, with npTDMS (extra `tdms`).

The channels of a group with the same start, increment and number of samples form a table. The times
of the rows are computed from the waveform properties of the channels (start, increment). If the
channels have no increment, the first channel of dates gives the times.
"""

from __future__ import annotations

import logging
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.name_list import listed
from frictool.errors import LogError
from frictool.logs.arrays.library_series import Series, SeriesTable
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import RawTable
from frictool.logs.text.header_units import is_unit, spelled

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

MAGIC = b"TDSm"
REPLACEMENT = "\ufffd"  # sign by which npTDMS replaces bytes that are not valid text
CUT = "its last segment is incomplete: the file is cut off, or its logger was switched off"
UNITS = ("unit_string", "NI_UnitDescription")


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins with the signature of TDMS."""
    return head.startswith(MAGIC)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table for each group and time base; raise LogError if no channel has numbers."""
    open_log(path).close()
    return open_guarded(path, _open)


def _open(path: Path) -> Sequence[LibraryTable]:
    from nptdms import TdmsFile

    logging.disable(logging.CRITICAL)
    file = TdmsFile.open(path.open("rb"))  # given a path, npTDMS would read the index file
    damage = CUT if file.file_status.incomplete_final_segment else None
    texts = [text for group in file.groups() for text in _texts(group)]
    if any(REPLACEMENT in text for text in texts):
        damage = "its names are not valid text"
    tables = [table for group in file.groups() for table in _tables(path, group, damage)]
    if not tables:
        channels = [channel.name for group in file.groups() for channel in group.channels()]
        raise LogError(path, f"has no channel of real numbers; found: {listed(channels)}")
    if len(tables) == 1:
        tables[0].topic = ""
    return tables


def _texts(group: Any) -> Iterator[str]:
    yield group.name
    for channel in group.channels():
        yield channel.name
        yield from channel.properties


def _tables(path: Path, group: Any, damage: str | None) -> list[SeriesTable]:
    bases: dict[tuple[Any, ...], list[Any]] = defaultdict(list)
    others = {}
    for channel in group.channels():
        if not len(channel):
            continue
        if channel.dtype.kind in "iufb" or channel.dtype.kind == "M":
            bases[_base(channel)].append(channel)
        else:
            others[channel.name] = f"a channel of {channel.dtype}"
    tables: list[SeriesTable] = []
    for base, channels in bases.items():
        numbers = [channel for channel in channels if channel.dtype.kind != "M"]
        dates = [channel for channel in channels if channel.dtype.kind == "M"]
        if not numbers:
            continue
        times, clock = _times(base), "wf_increment"
        if times is None and dates:
            times, clock = _dated(dates[0]), dates[0].name
        tables.append(
            SeriesTable(
                source=str(path),
                topic=group.name if len(bases) == 1 else f"{group.name} {len(tables) + 1}",
                columns={channel.name: _numbers(channel) for channel in numbers},
                units={channel.name: _unit(channel) for channel in numbers},
                others=others,
                clock=None if times is None else clock,
                rows=base[0],
                times=times,
                damage=damage,
            )
        )
    return tables


def _base(channel: Any) -> tuple[int, float | None, float, int]:
    properties = channel.properties
    increment = properties.get("wf_increment")
    start = properties.get("wf_start_time")
    start_ns = 0
    if isinstance(start, np.datetime64) and start.astype("M8[Y]").astype(int) >= 0:
        start_ns = int(start.astype("M8[ns]").astype(np.int64))
    return (
        len(channel),
        float(increment) if increment and float(increment) > 0.0 else None,
        float(properties.get("wf_start_offset", 0.0)),
        start_ns,
    )


def _times(base: tuple[int, float | None, float, int]) -> Series | None:
    _, increment, offset, start = base
    if increment is None:
        return None
    return lambda first, end: (
        start + np.rint(1e9 * (offset + increment * np.arange(first, end))).astype(np.int64)
    )


def _dated(channel: Any) -> Series:
    return lambda first, end: channel[first:end].astype("M8[ns]").astype(np.int64)


def _numbers(channel: Any) -> Series:
    return lambda first, end: channel[first:end]


def _unit(channel: Any) -> str | None:
    unit = next((channel.properties[key] for key in UNITS if channel.properties.get(key)), "")
    return spelled(unit) if isinstance(unit, str) and is_unit(unit) else None
