"""The logs of a fleet: those that are named, and those in the folders that are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from frictool.errors import LogError
from frictool.logs.origin import Name
from frictool.logs.recordings.parts import METADATA

# what in a folder is taken for a log; a file that is named by itself is read whatever it is called
SUFFIXES = (".mcap", ".bag", ".db3", ".csv", ".tsv", ".txt", ".mat", ".mf4", ".mdf", ".dat", ".parquet", ".pq", ".npz")


@dataclass(frozen=True)
class Member:
    """A log of the fleet, and what it is called: below the folder that was given, or as it was given itself."""

    path: Path
    name: Name


def is_fleet(logs: Sequence[Path]) -> bool:
    """Whether there are several logs, or a folder that is no recording by itself."""
    return len(logs) > 1 or (logs[0].is_dir() and not _is_bag(logs[0]))


def _is_bag(folder: Path) -> bool:
    """Whether a folder is one recording, a ROS 2 bag."""
    return (folder / METADATA).is_file()


def members(logs: Iterable[Path], without: Sequence[Path] = ()) -> list[Member]:
    """The logs that are named, and those in the folders that are, hidden ones left out; `without`: outputs, which are none.

    What is below one folder is called by where it is in it; below several, with the name of its own.

    Raises LogError where a folder has none.
    """
    logs = list(logs)
    several = sum(is_fleet([log]) for log in logs) > 1
    left_out = {path.resolve() for path in without}
    found: dict[Path, Member] = {}
    for log in logs:
        for member in _below(log, several) if is_fleet([log]) else [Member(log, Name(log.as_posix()))]:
            if member.path.resolve() not in left_out:
                found.setdefault(member.path.resolve(), member)
    return list(found.values())


def _below(folder: Path, named: bool) -> list[Member]:
    top = Path(folder.resolve().name if named else "")
    below = [(path, top / path.relative_to(folder)) for path in _logs(folder)]
    logs = [Member(path, Name(name.as_posix(), name.parent.name)) for path, name in below]
    if not logs:
        raise LogError(folder, f"holds no log; what counts as one ends in {', '.join(SUFFIXES)}, or is a ROS 2 bag")
    return logs


def _logs(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if path.is_dir() and not _is_bag(path):
            yield from _logs(path)
        elif path.is_dir() or path.suffix.lower() in SUFFIXES:
            yield path
