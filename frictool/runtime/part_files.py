"""Outputs that appear whole or not at all: written beside their target under a name that ends in
`.part`, then renamed.

A writer holds a lock on its part for as long as it lives. A process that is killed with SIGKILL
leaves its part without a lock; the next writer in that folder removes it.
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
except ImportError:  # Windows: a file that is open cannot be removed there
    fcntl = None  # type: ignore[assignment]  # Windows has none

SUFFIX = ".part"
PART = re.compile(r"\..+\.[a-z0-9_]{8}\.part", re.DOTALL)  # as tempfile names them
AGE_S = 86400.0  # without locks a part is stale if it was not written to for a day
_cleaned: set[Path] = set()


@contextmanager
def part_file(target: Path) -> Iterator[BinaryIO]:
    """Yield a binary stream that becomes `target` when the block ends without an exception, and is
    removed otherwise.

    Raises OSError where the folder is missing or the file cannot be written.
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
            if fcntl is not None:  # while the lock is held, no process takes it for stale
                part.replace(target)
        if fcntl is None:
            part.replace(target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


@contextmanager
def part_folder(target: Path) -> Iterator[Path]:
    """Yield an empty folder beside `target`, which is removed with what is left in it when the
    block ends."""
    _clean_once(target.parent)
    handle, part = _locked_folder(target)
    try:
        yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)
        if handle is not None:
            os.close(handle)


def stale_parts(folder: Path) -> list[Path]:
    """Return the parts in `folder` that belong to this user and that no process is writing."""
    with suppress(OSError), os.scandir(folder) as entries:
        return sorted(
            Path(entry.path)
            for entry in entries
            if PART.fullmatch(entry.name) and _is_stale(Path(entry.path))
        )
    return []


def remove_stale_parts(folder: Path) -> list[Path]:
    """Remove the parts in `folder` that killed processes left; return those that are gone."""
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
    """Remove stale parts, once in each folder and process."""
    if folder not in _cleaned:
        _cleaned.add(folder)
        remove_stale_parts(folder)


def _locked_file(target: Path) -> tuple[int, Path]:
    """Return the open handle and the path of a new part. One that was removed before it had its
    lock is made anew."""
    while True:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=SUFFIX)
        if fcntl is None:
            return handle, Path(name)
        with suppress(OSError):  # a file system without locks
            fcntl.flock(
                handle, fcntl.LOCK_EX
            )  # waits while another process checks whether the part is stale
        with suppress(OSError):
            if os.path.samestat(os.stat(name), os.fstat(handle)):
                return handle, Path(name)
        os.close(handle)


def _locked_folder(target: Path) -> tuple[int | None, Path]:
    """Return the handle that holds the lock of a new folder, None where there are no locks, and its
    path."""
    while True:
        part = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}.", suffix=SUFFIX))
        handle = _lock(part, wait=True)
        if part.exists():
            return handle, part
        if handle is not None:
            os.close(handle)


def _lock(part: Path, wait: bool = False) -> int | None:
    """Return a handle that holds the lock of a part; None where another process has it, or where
    there are no locks."""
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
    """Return whether a part is this user's and no process writes it."""
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
