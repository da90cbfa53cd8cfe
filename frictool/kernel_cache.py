"""The folders that compiled kernels are kept in: their names, who uses one, which are left over, and how one is written.

A folder belongs to one state of the kernels' sources and of what compiled them (numba, llvmlite, Python, processor), so that an upgrade
finds a new one, and two versions side by side never read each other's. The folders of former states are left over; they are removed
when a new one is made, unless a process holds them.

numba itself locks nothing: of two processes that keep different signatures of one function at the same time, the index may name the other's
code. Whoever writes holds a lock here. What cannot be read (a disk that was full, a machine that lost power) is compiled again.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows: what is in use is then told by its age alone
    fcntl = None  # type: ignore[assignment]  # Windows has none

PREFIX = "kernels-"
REMOVED = ".removed-"
USED = "in_use"  # shared by all who use a folder, for as long as they live; its date is the last start
WRITTEN = "written"  # held while something is kept
KEPT = 8  # folders left over that are kept for whoever goes back to an older state
AGE_S = 14 * 86400.0  # unused for longer, they are removed all the same
REST_S = 3600.0  # used within it, they are left alone: what used them may be too old to hold a lock
PATIENCE_S = 20.0  # to wait for another writer, who takes milliseconds; then nothing is kept
_held: list[int] = []


@dataclass(frozen=True)
class Folder:
    """A folder of compiled kernels: its size in bytes, when a process last began to use it (s since 1970), whether one still does."""

    path: Path
    size: int
    used: float
    busy: bool


def folder_name(package: Path, rooms: tuple[str, ...], toolchain: str) -> str:
    """The name of the folder for the sources of `rooms` in `package`, compiled by `toolchain`."""
    seen = hashlib.sha256(toolchain.encode() + b"\0")
    for room in rooms:
        for source in sorted((package / room).glob("*.py")):
            seen.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return PREFIX + seen.hexdigest()[:16]


def distrust(folder: Path, sources: Path) -> str:
    """Return why code in `folder` is not loaded; "" where this user, root, or the owner of `sources` alone can write there.

    What is kept is machine code and pickles: whoever writes it runs as whoever loads it.
    """
    if not hasattr(os, "geteuid"):
        return ""  # Windows: the user's folders are the user's
    trusted = {0, os.geteuid(), sources.stat().st_uid}
    parent = folder.parent.stat()
    if parent.st_mode & stat.S_IWOTH and not parent.st_mode & stat.S_ISVTX:
        return f"everybody can write in {folder.parent}"
    inside = [Path(entry.path) for entry in os.scandir(folder) if entry.is_dir()]
    for path in (folder, *inside):
        for status in (path.lstat(), path.stat()):  # of a link, and of what it leads to
            if status.st_uid not in trusted:
                return f"{path} belongs to user {status.st_uid}"
        if path.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            return f"others can write in {path}"
    return ""


@contextmanager
def private() -> Iterator[None]:
    """Keep others from writing what is made in the block, whatever the process's umask is."""
    before = os.umask(0o022)
    os.umask(before | 0o022)
    try:
        yield
    finally:
        os.umask(before)


def folders(place: Path) -> list[Folder]:
    """The folders of kernels in `place`, the one used last first."""
    found = []
    for path in sorted(place.glob(f"{PREFIX}*")):
        with suppress(OSError):  # removed by another process in between
            found.append(Folder(path, _size(path), _last_used(path), _is_held(path)))
    return sorted(found, key=lambda folder: -folder.used)


def _size(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        with suppress(OSError):
            total += path.stat().st_size
    return total


def _last_used(folder: Path) -> float:
    """By the date of its lock; where it has none, of what was kept last."""
    with suppress(OSError):
        return (folder / USED).stat().st_mtime
    return max(path.stat().st_mtime for path in (folder, *folder.iterdir()))


def hold(folder: Path) -> None:
    """Marks an existing folder as used by this process until it ends. Where the file system has no locks nothing is marked."""
    with suppress(OSError):
        while True:
            handle = os.open(folder / USED, os.O_RDWR | os.O_CREAT, 0o666)
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_SH)  # waits for whoever removes it
            if _is_still(folder / USED, handle):
                break
            os.close(handle)
            folder.mkdir(parents=True, exist_ok=True)
        os.utime(handle)
        _held.append(handle)


def _is_still(path: Path, handle: int) -> bool:
    """Whether `path` is the file that `handle` opened: its folder may have been removed in between."""
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except OSError:
        return False


def _is_held(folder: Path) -> bool:
    """Whether a process uses it."""
    taken = _take(folder)
    if taken is None:
        return (folder / USED).exists()
    os.close(taken)
    return False


def _take(folder: Path) -> int | None:
    """The lock of a folder that nobody uses, for oneself; None where somebody does, or where there are no locks."""
    if fcntl is None:
        return None
    try:
        handle = os.open(folder / USED, os.O_RDWR)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        return None
    return handle


def remove(folder: Path, now: float | None = None) -> bool:
    """Removes a folder that nobody uses nor used within the last hour; False where it is left."""
    now = time.time() if now is None else now
    try:
        rested = now - _last_used(folder) > REST_S
    except (OSError, ValueError):
        return False
    if not rested:
        return False
    locked = (folder / USED).exists()
    taken = _take(folder)
    if locked and taken is None and fcntl is not None:
        return False
    try:
        away = folder.with_name(f"{REMOVED}{folder.name}-{os.getpid()}")  # in one step, so that nobody finds half of it
        folder.rename(away)
    except OSError:
        return False
    finally:
        if taken is not None:
            os.close(taken)
    shutil.rmtree(away, ignore_errors=True)
    return True


def prune(place: Path, current: Path) -> list[Path]:
    """Removes what former states left in `place`: all but the last `KEPT`, and of these what was unused for a fortnight."""
    now = time.time()
    others = []
    for path in place.glob(f"{PREFIX}*"):
        with suppress(OSError, ValueError):
            others += [(_last_used(path), path)] if path != current else []
    others.sort(reverse=True)
    old = [path for place_in_row, (used, path) in enumerate(others) if place_in_row >= KEPT or now - used > AGE_S]
    for path in place.glob(f"{REMOVED}*"):  # of a process that was killed while it removed
        shutil.rmtree(path, ignore_errors=True)
    return [path for path in old if remove(path, now)]


@contextmanager
def writing(folder: Path) -> Iterator[bool]:
    """Keeps others from writing in `folder` for the block; gives False where that cannot be had, and nothing should be written."""
    try:
        handle = os.open(folder / WRITTEN, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:
        yield False
        return
    try:
        yield _locked(handle)
    finally:
        if fcntl is not None:
            with suppress(OSError):
                fcntl.flock(handle, fcntl.LOCK_UN)  # by name: a child that was forked meanwhile has the handle too
        os.close(handle)


def _locked(handle: int) -> bool:
    if fcntl is None:
        return True
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        except OSError:  # no locks on this file system: as numba does it
            return True


def guard(cache: Any, folder: Path) -> None:
    """Makes a numba cache write under the lock of `folder`, and live with a disk that is full or an entry that is damaged."""
    load: Callable[..., Any] = cache.load_overload
    save: Callable[..., None] = cache.save_overload

    def load_overload(signature: Any, context: Any) -> Any:
        try:
            return load(signature, context)
        except Exception:  # a damaged pickle raises nearly anything
            _forget(cache, folder)
            return None

    def save_overload(signature: Any, compiled: Any) -> None:
        with private(), writing(folder) as mine, suppress(OSError):  # what cannot be kept is compiled again next time
            if mine:
                save(signature, compiled)

    cache.load_overload, cache.save_overload = load_overload, save_overload


def _forget(cache: Any, folder: Path) -> None:
    """Removes all that is kept of one function: code left without its index would be taken for another signature's."""
    index = Path(cache._cache_file._index_path)
    with writing(folder), suppress(OSError):
        index.unlink(missing_ok=True)
        for path in index.parent.glob(f"{index.stem}.*.nbc"):
            path.unlink(missing_ok=True)
