"""The logs of a fleet: those that are named, and those in the folders that are."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from frictool.documents.provenance import readable
from frictool.errors import LogError
from frictool.logs.origin import LogName
from frictool.logs.recordings.recording_files import METADATA

# what in a folder is taken for a log; a file that is named by itself is read whatever it is called
SUFFIXES = (
    ".mcap",
    ".bag",
    ".db3",
    ".csv",
    ".tsv",
    ".txt",
    ".mat",
    ".mf4",
    ".mdf",
    ".dat",
    ".parquet",
    ".pq",
    ".npz",
)

TABLE_HEAD = ("unit", "date", "file")  # what every table about logs opens with
PARQUET_MAGIC = b"PAR1"


@dataclass(frozen=True)
class FleetLog:
    """A log of the fleet, and what it is called: below the folder that was given, or as it was
    given itself."""

    path: Path
    name: LogName


def is_fleet(logs: Sequence[Path]) -> bool:
    """Whether there are several logs, or a folder that is no recording by itself."""
    return len(logs) > 1 or (logs[0].is_dir() and not _is_bag(logs[0]))


def _is_bag(folder: Path) -> bool:
    """Whether a folder is one recording, a ROS 2 bag."""
    return (folder / METADATA).is_file()


def members(logs: Iterable[Path]) -> list[FleetLog]:
    """The logs that are named, and those in the folders that are. Hidden ones are left out, and
    tables about logs: an earlier run may have written its own beside them.

    What is below one folder is called by where it is in it; below several, with the name of its
    own.

    Raises LogError where a folder has none.
    """
    logs = list(logs)
    several = sum(is_fleet([log]) for log in logs) > 1
    found: dict[Path, FleetLog] = {}
    for log in logs:
        for member in (
            _below(log, several)
            if is_fleet([log])
            else [FleetLog(log, LogName(readable(log.as_posix())))]
        ):
            if not is_table(member.path):
                found.setdefault(member.path.resolve(), member)
    if not found:
        raise LogError(
            logs[0],
            "is a table about logs, or holds nothing else; name logs, or the folder that they are in",
        )
    return list(found.values())


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
            f"holds no log; what counts as one ends in {', '.join(SUFFIXES)}, or is a ROS 2 bag",
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
    """Whether a file is a table about logs, CSV or Parquet, that frictool has written: told by its
    columns and not by its name, so that a log is never taken for one. False where it cannot be
    read.
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
    """The metadata of a Parquet file. Raises ValueError or OSError where it is cut."""
    end = stream.seek(-8, io.SEEK_END)
    size = int.from_bytes(stream.read(4), "little")
    if not 0 < size <= end:
        raise ValueError("no footer")
    stream.seek(end - size)
    return stream.read(size)


def _opens_with(footer: bytes, names: Sequence[str]) -> bool:
    """Whether the schema's first columns have these names. They stand in the footer in their order,
    each with its length before it, and what frictool wrote tells its version beside them.
    """
    found = [footer.find(bytes([len(name)]) + name.encode()) for name in names]
    return found[0] >= 0 and found == sorted(found) and b"frictool" in footer
