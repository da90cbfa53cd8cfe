"""Management of the folders with compiled kernels: names, last use, write lock and removal.

machine_code_store.py saves and loads the code in these folders.

A folder belongs to one toolchain (numba, llvmlite, numpy, Python, processor), so that an upgrade
starts a new folder. In this folder, each state (version) of a module's sources has a subfolder
(machine_code_store.py), so that two versions of frictool never read each other's code. When a new
folder is made, old folders of former toolchains and states are removed (`prune`). A folder is kept
if a process uses it, or used it within the last hour.

numba itself locks nothing: if two processes write different signatures of one function at the same
time, the index may name the wrong code. Therefore a process locks the folder while it writes. An
unreadable entry (after a full disk or a power loss) is compiled again.
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
except ImportError:  # Windows, on which only the age of a folder shows that it is in use
    fcntl = None  # type: ignore[assignment]  # Windows has none

PREFIX = "kernels-"
LAYOUT = 2  # version of the folder layout
REMOVED = ".removed-"
USED = "in_use"  # lock file shared by all processes that use a folder; its date is the last start
WRITTEN = "written"  # lock file held while code is written
# number of former folders in one parent folder, and of former states of one module, that are kept
KEPT = 8
AGE_S = 14 * 86400.0  # s, former folders unused for longer are removed even if fewer than KEPT
REST_S = 3600.0  # s, a folder used more recently stays: old versions of frictool hold no lock
# s, longest wait for another process that writes; after this time, no code is stored
PATIENCE_S = 20.0
_held: list[int] = []


@dataclass(frozen=True)
class KernelFolder:
    """Folder of compiled kernels.

    size: total size of the files [bytes].
    used: start time of the last process that used the folder [s since 1970].
    busy: True if a process uses the folder now.
    """

    path: Path
    size: int
    used: float
    busy: bool


def folder_name(toolchain: str) -> str:
    """Return the name of the folder of a toolchain."""
    return PREFIX + hashlib.sha256(f"{LAYOUT}\0{toolchain}".encode()).hexdigest()[:16]


def untrusted_reason(folder: Path, sources: Path) -> str:
    """Return why code from `folder` must not be loaded; "" if it can be trusted.

    The folder is trusted if only this user, root and the owner of `sources` can write in it. The
    files are machine code and pickles: whoever can write them can run code as the user who loads
    them.
    """
    if not hasattr(os, "geteuid"):
        return ""  # Windows, on which the user's folders belong to the user
    trusted = {0, os.geteuid(), sources.stat().st_uid}
    parent = folder.parent.stat()
    if parent.st_mode & stat.S_IWOTH and not parent.st_mode & stat.S_ISVTX:
        return f"everybody can write in {folder.parent}"
    inside = [Path(entry.path) for entry in os.scandir(folder) if entry.is_dir()]
    for path in (folder, *inside):
        try:
            link, target = path.lstat(), path.stat()
        except FileNotFoundError:  # removed by another process in between
            continue
        strangers = {link.st_uid, target.st_uid} - trusted
        if strangers:
            return f"{path} belongs to user {min(strangers)}"
        if target.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            return f"others can write in {path}"
    return ""


@contextmanager
def restricted_umask() -> Iterator[None]:
    """Create files in the with-block without write permission for other users."""
    before = os.umask(0o022)
    os.umask(before | 0o022)
    try:
        yield
    finally:
        os.umask(before)


def folders(parent: Path) -> list[KernelFolder]:
    """Return the kernel folders in `parent`, most recently used first."""
    cached = []
    for path in sorted(parent.glob(f"{PREFIX}*")):
        with suppress(OSError):  # removed by another process in between
            cached.append(KernelFolder(path, _size(path), _last_used(path), _is_held(path)))
    return sorted(cached, key=lambda folder: -folder.used)


def _size(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        with suppress(OSError):
            total += path.stat().st_size
    return total


def _last_used(folder: Path) -> float:
    with suppress(OSError):
        return (folder / USED).stat().st_mtime
    return max(path.stat().st_mtime for path in (folder, *folder.iterdir()))


def mark_used(folder: Path) -> None:
    """Mark a folder as used until this process ends; do nothing on a file system without locks."""
    with suppress(OSError):
        while True:
            handle = os.open(folder / USED, os.O_RDWR | os.O_CREAT, 0o666)
            if fcntl is not None:
                # wait for a process that is removing the folder
                fcntl.flock(handle, fcntl.LOCK_SH)
            if _is_still(folder / USED, handle):
                break
            os.close(handle)
            folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder / USED)  # by path, because Windows accepts no handle here
        _held.append(handle)


def _is_still(path: Path, handle: int) -> bool:
    """Return True if `path` still denotes the open file `handle`; False if it was removed."""
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except OSError:
        return False


def _is_held(folder: Path) -> bool:
    taken = _take(folder)
    if taken is None:
        return (folder / USED).exists()
    os.close(taken)
    return False


def _take(folder: Path) -> int | None:
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
    """Remove a kernel folder; return False if it is kept (recent use, in use, or an error)."""
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
        # renamed in one step, so that no process sees it half removed
        away = folder.with_name(f"{REMOVED}{folder.name}-{os.getpid()}")
        folder.rename(away)
    except OSError:
        return False
    finally:
        if taken is not None:
            os.close(taken)
    shutil.rmtree(away, ignore_errors=True)
    return True


def prune(parent: Path, current: Path) -> list[Path]:
    """Remove old kernel folders in `parent`; return the removed folders.

    The folder `current` is kept. The `KEPT` most recently used of the other folders are also kept,
    unless they were unused for a fortnight.
    """
    now = time.time()
    others = []
    for path in parent.glob(f"{PREFIX}*"):
        with suppress(OSError, ValueError):
            others += [(_last_used(path), path)] if path != current else []
    others.sort(reverse=True)
    old = [
        path
        for place_in_row, (used, path) in enumerate(others)
        if place_in_row >= KEPT or now - used > AGE_S
    ]
    for path in parent.glob(f"{REMOVED}*"):  # left by a process that was killed during the removal
        shutil.rmtree(path, ignore_errors=True)
    return [path for path in old if remove(path, now)]


def prune_states(current: Path) -> list[Path]:
    """Remove folders with code of old sources of one module; return the removed folders.

    `current` is the folder of the present sources; `prune` explains which folders stay.
    """
    now = time.time()
    others = [
        one
        for one in states(current.parent)
        if one.path != current and module_of(one.path) == module_of(current)
    ]
    old = [one for index, one in enumerate(others) if index >= KEPT or now - one.used > AGE_S]
    return [one.path for one in old if remove_state(one.path, now)]


def states(folder: Path) -> list[KernelFolder]:
    """Return the folders of module states (versions of a module's sources), latest used first."""
    cached = []
    with suppress(OSError):
        for entry in os.scandir(folder):
            with suppress(OSError):
                if entry.is_dir() and not entry.name.startswith("."):
                    cached.append(KernelFolder(Path(entry.path), 0, entry.stat().st_mtime, False))
    return sorted(cached, key=lambda one: (-one.used, one.path))


def module_of(state: Path) -> str:
    """Return the name of the module (without `frictool.`) whose code is in the folder `state`."""
    return state.name.rpartition("-")[0]


def sized(state: KernelFolder) -> KernelFolder:
    """Return the record of a folder, completed with the size of the folder's files [bytes]."""
    return replace(state, size=_size(state.path))


def remove_state(state: Path, now: float | None = None) -> bool:
    """Remove the code of one module state; return False if it is kept (recent use, or locked)."""
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
    """Lock `folder` for writing in the with-block; yield False if the caller must not write."""
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
                # unlock explicitly, because a child process that was forked meanwhile also has the
                # handle
                fcntl.flock(handle, fcntl.LOCK_UN)
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
        except OSError:  # no locks on this file system: write unguarded, as numba does
            return True
