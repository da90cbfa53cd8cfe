"""Logs of a fleet: the listed files and the logs in the listed folders."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from frictool.documents.provenance import readable
from frictool.errors import LogError
from frictool.logs.formats import SUFFIXES
from frictool.logs.origin import LogName
from frictool.logs.recordings.recording_files import METADATA

TABLE_HEAD = ("unit", "date", "file")  # first columns of every table about logs
PARQUET_MAGIC = b"PAR1"


@dataclass(frozen=True)
class FleetLog:
    """Log file of a fleet.

    name: path that is shown to the user (see `members`).
    """

    path: Path
    name: LogName


def is_fleet(logs: Sequence[Path]) -> bool:
    """Return True if `logs` has several paths, or a single folder that is not a ROS 2 bag."""
    return len(logs) > 1 or (logs[0].is_dir() and not _is_bag(logs[0]))


def _is_bag(folder: Path) -> bool:
    return (folder / METADATA).is_file()


def members(logs: Iterable[Path]) -> list[FleetLog]:
    """Return the listed logs and all logs in the listed folders.

    Hidden files, and tables of results that frictool wrote, are left out. If one folder is listed,
    the names of its logs are paths relative to this folder. If several folders are listed, each
    name begins with the name of the folder.

    Raises LogError if a folder contains no log, or if all files are tables of results.
    """
    logs = list(logs)
    several = sum(is_fleet([log]) for log in logs) > 1
    by_path: dict[Path, FleetLog] = {}
    for log in logs:
        for member in (
            _below(log, several)
            if is_fleet([log])
            else [FleetLog(log, LogName(readable(log.as_posix())))]
        ):
            if not is_table(member.path):
                by_path.setdefault(member.path.resolve(), member)
    if not by_path:
        raise LogError(
            logs[0],
            "is a table of results, or contains only such tables; give logs, or a folder of logs",
        )
    return list(by_path.values())


def _below(folder: Path, named: bool) -> list[FleetLog]:
    top = Path(folder.resolve().name if named else "")
    below = [(path, top / path.relative_to(folder)) for path in _logs(folder)]
    logs = [
        FleetLog(path, LogName(readable(name.as_posix()), readable(name.parent.name)))
        for path, name in below
    ]
    if not logs:
        raise LogError(
            folder,
            (f"contains no log; logs are ROS 2 bags and files that end in {', '.join(SUFFIXES)}"),
        )
    return logs


def _logs(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if path.is_dir() and not _is_bag(path):
            yield from _logs(path)
        elif path.is_dir() or path.suffix.lower() in SUFFIXES:
            yield path


def is_table(path: Path) -> bool:
    """Return True if a file is a table of results about logs (CSV or Parquet) that frictool wrote.

    The columns are checked, not the file name. The result is False if the file cannot be read.
    """
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            if path.suffix.lower() == ".csv":
                return stream.readline(1000).startswith(",".join(TABLE_HEAD).encode() + b",")
            if path.suffix.lower() in (".parquet", ".pq") and stream.read(4) == PARQUET_MAGIC:
                return _opens_with(_footer(stream), TABLE_HEAD)
    except (OSError, ValueError):
        pass
    return False


def _footer(stream: BinaryIO) -> bytes:
    end = stream.seek(-8, io.SEEK_END)
    size = int.from_bytes(stream.read(4), "little")
    if not 0 < size <= end:
        raise ValueError("no footer")
    stream.seek(end - size)
    return stream.read(size)


def _opens_with(footer: bytes, names: Sequence[str]) -> bool:
    """Return True if frictool wrote this Parquet footer and `names` are the first columns."""
    positions = [footer.find(bytes([len(name)]) + name.encode()) for name in names]
    return positions[0] >= 0 and positions == sorted(positions) and b"frictool" in footer
