"""The folders that compiled kernels are kept in: their names, the processes that use them, their
removal, and the lock for writing.

A folder belongs to one toolchain (numba, llvmlite, numpy, Python, processor), so that an upgrade
finds a new one. In it, each state of a module's sources has a folder of its own (kernel_store.py):
two versions of frictool never read each other's code. Folders of former toolchains and states are
removed when a new one is made, unless a process holds them or used them within the hour.

numba itself locks nothing: if two processes keep different signatures of one function at the same
time, the index may name the wrong code. A process that writes holds a lock here. An entry that
cannot be read (a disk that was full, a machine that lost power) is compiled again.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: what is in use is then told by its age alone
    fcntl = None  # type: ignore[assignment]  # Windows has none

PREFIX = "kernels-"
LAYOUT = 2  # of the folder of a toolchain
REMOVED = ".removed-"
USED = (
    "in_use"  # shared by all who use a folder, for as long as they live; its date is the last start
)
WRITTEN = "written"  # held while something is kept
# former folders of a place, and former states of a module, that are kept for a return to them
KEPT = 8
AGE_S = 14 * 86400.0  # unused for longer, they are removed all the same
REST_S = 3600.0  # used within it, they are left alone: what used them may be too old to hold a lock
PATIENCE_S = 20.0  # to wait for another writer, who takes milliseconds; then nothing is kept
_held: list[int] = []


@dataclass(frozen=True)
class KernelFolder:
    """A folder of compiled kernels: its size in bytes, when a process last began to use it (s since
    1970), whether one still does."""

    path: Path
    size: int
    used: float
    busy: bool


def folder_name(toolchain: str) -> str:
    """Return the name of the folder for what `toolchain` compiles."""
    return PREFIX + hashlib.sha256(f"{LAYOUT}\0{toolchain}".encode()).hexdigest()[:16]


def untrusted_reason(folder: Path, sources: Path) -> str:
    """Return why code in `folder` is not loaded; "" where this user, root, or the owner of
    `sources` alone can write there.

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
def restricted_umask() -> Iterator[None]:
    """Keep others from writing what is made in the block, whatever the process's umask is."""
    before = os.umask(0o022)
    os.umask(before | 0o022)
    try:
        yield
    finally:
        os.umask(before)


def folders(place: Path) -> list[KernelFolder]:
    """The folders of kernels in `place`, the one used last first."""
    found = []
    for path in sorted(place.glob(f"{PREFIX}*")):
        with suppress(OSError):  # removed by another process in between
            found.append(KernelFolder(path, _size(path), _last_used(path), _is_held(path)))
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


def mark_used(folder: Path) -> None:
    """Marks an existing folder as used by this process until it ends. Where the file system has no
    locks nothing is marked."""
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
    """Whether `path` is the file that `handle` opened: its folder may have been removed in
    between."""
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
    """The lock of a folder that nobody uses, for oneself; None where somebody does, or where there
    are no locks."""
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
        away = folder.with_name(
            f"{REMOVED}{folder.name}-{os.getpid()}"
        )  # in one step, so that nobody finds half of it
        folder.rename(away)
    except OSError:
        return False
    finally:
        if taken is not None:
            os.close(taken)
    shutil.rmtree(away, ignore_errors=True)
    return True


def prune(place: Path, current: Path) -> list[Path]:
    """Removes what former states left in `place`: all but the last `KEPT`, and of these what was
    unused for a fortnight."""
    now = time.time()
    others = []
    for path in place.glob(f"{PREFIX}*"):
        with suppress(OSError, ValueError):
            others += [(_last_used(path), path)] if path != current else []
    others.sort(reverse=True)
    old = [
        path
        for place_in_row, (used, path) in enumerate(others)
        if place_in_row >= KEPT or now - used > AGE_S
    ]
    for path in place.glob(f"{REMOVED}*"):  # of a process that was killed while it removed
        shutil.rmtree(path, ignore_errors=True)
    return [path for path in old if remove(path, now)]


def prune_states(current: Path) -> list[Path]:
    """Remove former states of the module that `current` is the folder of: all but the last `KEPT`,
    and those unused for a fortnight."""
    now = time.time()
    others = [
        one
        for one in states(current.parent)
        if one.path != current and module_of(one.path) == module_of(current)
    ]
    old = [one for index, one in enumerate(others) if index >= KEPT or now - one.used > AGE_S]
    return [one.path for one in old if remove_state(one.path, now)]


def states(folder: Path) -> list[KernelFolder]:
    """Return the folders of the states of modules in the folder of a toolchain, the one used last
    first."""
    found = []
    with suppress(OSError):
        for entry in os.scandir(folder):
            with suppress(OSError):
                if entry.is_dir() and not entry.name.startswith("."):
                    found.append(KernelFolder(Path(entry.path), 0, entry.stat().st_mtime, False))
    return sorted(found, key=lambda one: (-one.used, one.path))


def module_of(state: Path) -> str:
    """Return the name of the module that a state's folder belongs to, as far as the folder has
    it."""
    return state.name.rpartition("-")[0]


def sized(state: KernelFolder) -> KernelFolder:
    """Return the same folder with its size."""
    return replace(state, size=_size(state.path))


def remove_state(state: Path, now: float | None = None) -> bool:
    """Remove the folder of a state that was not used within the last hour; False where it is
    left."""
    away = state.parent / f"{REMOVED}{state.name}-{os.getpid()}"
    with writing(state.parent) as mine:
        try:
            if not mine or (time.time() if now is None else now) - state.stat().st_mtime <= REST_S:
                return False
            state.rename(away)
        except OSError:
            return False
    shutil.rmtree(away, ignore_errors=True)
    return True


@contextmanager
def writing(folder: Path) -> Iterator[bool]:
    """Keeps others from writing in `folder` for the block; gives False where that cannot be had,
    and nothing should be written."""
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
                fcntl.flock(
                    handle, fcntl.LOCK_UN
                )  # by name: a child that was forked meanwhile has the handle too
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
