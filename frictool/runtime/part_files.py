"""Output files that appear complete or not at all.

An output is written next to its target, into a part file whose name ends in `.part`. The part file
is then renamed. The writing process holds a lock on the part file. A process killed with SIGKILL
leaves an unlocked part file, which the next process that writes in the folder removes.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # Windows, which cannot remove an open file
    fcntl = None  # type: ignore[assignment]  # Windows has none

SUFFIX = ".part"
PART = re.compile(r"\..+\.[a-z0-9_]{8}\.part", re.DOTALL)  # file names made by tempfile
AGE_S = 86400.0  # s, age at which a part file is stale if there are no locks
_cleaned: set[Path] = set()


@contextmanager
def part_file(target: Path) -> Iterator[BinaryIO]:
    """Yield a binary stream that becomes `target` if the with-block ends without an exception.

    After an exception the part file is removed. Raises OSError if the folder is missing or the file
    cannot be written.
    """
    _clean_once(target.parent)
    handle, part = _locked_file(target)
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
            stream.flush()
            umask = os.umask(0)
            os.umask(umask)
            part.chmod(0o666 & ~umask)
            # rename under the lock, so that no process regards the part file as stale
            if fcntl is not None:
                part.replace(target)
        if fcntl is None:
            part.replace(target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


@contextmanager
def part_folder(target: Path) -> Iterator[Path]:
    """Yield an empty folder next to `target`; remove it with its content after the with-block."""
    _clean_once(target.parent)
    handle, part = _locked_folder(target)
    try:
        yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)
        if handle is not None:
            os.close(handle)


def stale_parts(folder: Path) -> list[Path]:
    """Return this user's part files and part folders in `folder` that no process is writing."""
    with suppress(OSError), os.scandir(folder) as entries:
        return sorted(
            Path(entry.path)
            for entry in entries
            if PART.fullmatch(entry.name) and _is_stale(Path(entry.path))
        )
    return []


def remove_stale_parts(folder: Path) -> list[Path]:
    """Remove part files and part folders that no process is writing; return the removed paths."""
    gone = []
    for part in stale_parts(folder):
        handle = _lock(part)
        if handle is None and fcntl is not None:
            continue
        try:
            if part.is_dir():
                shutil.rmtree(part, ignore_errors=True)
            else:
                part.unlink(missing_ok=True)
        except OSError:
            continue
        finally:
            if handle is not None:
                os.close(handle)
        gone.append(part)
    return gone


def _clean_once(folder: Path) -> None:
    if folder not in _cleaned:
        _cleaned.add(folder)
        remove_stale_parts(folder)


def _locked_file(target: Path) -> tuple[int, Path]:
    """Make a locked part file; return its open handle and its path.

    If another process removes the file before it is locked, a new file is made.
    """
    while True:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=SUFFIX)
        if fcntl is None:
            return handle, Path(name)
        with suppress(OSError):  # a file system without locks
            # blocks while another process checks whether the part file is stale
            fcntl.flock(handle, fcntl.LOCK_EX)
        with suppress(OSError):
            if os.path.samestat(os.stat(name), os.fstat(handle)):
                return handle, Path(name)
        os.close(handle)


def _locked_folder(target: Path) -> tuple[int | None, Path]:
    while True:
        part = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}.", suffix=SUFFIX))
        handle = _lock(part, wait=True)
        if part.exists():
            return handle, part
        if handle is not None:
            os.close(handle)


def _lock(part: Path, wait: bool = False) -> int | None:
    if fcntl is None:
        return None
    try:
        handle = os.open(part, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        return None
    return handle


def _is_stale(part: Path) -> bool:
    try:
        status = part.lstat()
    except OSError:
        return False
    if hasattr(os, "getuid") and status.st_uid != os.getuid():
        return False
    if fcntl is None:
        return time.time() - status.st_mtime > AGE_S
    handle = _lock(part)
    if handle is not None:
        os.close(handle)
    return handle is not None
