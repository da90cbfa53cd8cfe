"""Storage of machine code on disk: KernelStore saves and loads the code of one function.

Each state of a module's sources has its own folder. kernel_folders.py manages these folders: names,
use, locks and removal.

KernelStore names the folder after the module and the digest of all sources that the module imports
(kernel_sources.py). A process that finds no code takes a lock and compiles; other processes that
need the same code wait.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba.experimental.function_type  # noqa: F401  # lets kernels take kernels as arguments
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher
from numba.core.environment import Environment
from numba.core.runtime.nrt import rtsys

from frictool.runtime import notifications
from frictool.runtime.deferred_imports import defer_parts_of_numpy, import_array_functions
from frictool.runtime.kernel_folders import prune_states, restricted_umask, writing
from frictool.runtime.kernel_sources import INSTALLED, PACKAGE, Sources, State, UnknownSourcesError

try:
    import fcntl
except ImportError:  # Windows, on which two processes may compile the same kernel at once
    fcntl = None  # type: ignore[assignment]  # Windows has none

defer_parts_of_numpy()
# lock file; one byte of it is locked for each kernel that is being compiled
COMPILING = "compiling"
PATIENCE_S = 300.0  # s, longest wait for another process that compiles the same kernel
LINKED = "-linked"  # form of code that other kernels link
POLL_S = 0.02  # s, time between two attempts to lock


class _Entry:
    """Folder with the code of one function; it has the methods of a cache locator of numba."""

    def __init__(self, folder: Path, source: str) -> None:
        self.folder, self._py_file = folder, source

    def get_cache_path(self) -> str:
        return str(self.folder)

    def ensure_cache_path(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        return self.folder.name


class _Form(CompileResultCacheImpl):
    """numba's serialization of compiled code, with the folder and file names of KernelStore."""

    def __init__(self, entry: _Entry, name: str, line: int) -> None:
        self._locator, self._filename_base, self._lineno = entry, name, line

    def reduce(self, compiled: Any) -> tuple[Any, ...]:
        """Return the parts of compiled code that are pickled.

        The environments of numba's functions refer to the package numba instead of the modules that
        define the functions. Therefore, loading does not import these modules. Code without Python
        objects reads only the constants of an environment.
        """
        *parts, environments = super().reduce(compiled)  # type: ignore[no-untyped-call]  # numba has no types
        return (*parts, tuple(map(_without_module, environments)))


def _without_module(environment: Environment) -> Environment:
    if not environment.globals["__name__"].startswith("numba."):
        return environment
    bare = Environment({"__name__": "numba"})
    bare.consts[:] = environment.consts
    bare.env_name = environment.env_name
    return bare


class KernelStore(FunctionCache):
    """Store of one function's machine code in `folder`, used by numba as its cache.

    `form`: name of the form of the code; "" for the form that Python calls.
    """

    def __init__(self, function: Any, folder: Path, form: str = "") -> None:
        self._py_func = function
        self._name = repr(function)
        self._enabled = True
        self._folder = folder
        self._form = form
        self._claims: dict[Any, int] = {}
        self._source = function.__code__.co_filename
        self._module = module_of(function)
        sources_of(folder, self._module, self._source).declare(Path(self._source))

    @property
    def cache_path(self) -> str:
        """Return the folder of the machine code."""
        return str(self._folder)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the stored code; None if this process must compile it, while others wait."""
        rtsys.initialize(context)  # the only part of numba's context that stored code needs
        overload = self._stored(signature, context)
        if overload is None:
            import_array_functions()
        return overload

    def _stored(self, signature: Any, context: Any) -> Any:
        if not self._place(signature):
            return None
        overload = self._load(signature, context)
        if overload is None and self._claim(signature):
            overload = self._load(signature, context)
            if overload is not None:
                self.release()
        return overload

    def _load(self, signature: Any, context: Any) -> Any:
        try:
            return super()._load_overload(signature, context)  # type: ignore[no-untyped-call]  # numba has no types
        except Exception:  # a damaged pickle can raise almost any exception
            self._forget()
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Store compiled code if its sources are known and its folder is writable."""
        try:
            if self._place(signature) and self._reaches_known_sources():
                # code that cannot be written is compiled again next time
                with restricted_umask(), writing(self._folder) as mine, suppress(OSError):
                    if mine:
                        super()._save_overload(signature, compiled)  # type: ignore[no-untyped-call]  # as above
        finally:
            self.release()

    def release(self) -> None:
        """Release all locks of this process, so that other processes can compile the kernels."""
        for byte in self._claims.values():
            _unlock(self._folder, byte)
        self._claims.clear()

    def is_kept(self) -> bool:
        """Return True if the function's code is on disk for at least one set of argument types."""
        return self._place(()) and os.path.exists(self._cache_file._index_path)

    def _place(self, signature: Any) -> bool:
        if any(
            isinstance(one, (Dispatcher, types.Dispatcher))
            for one in [*_parts(signature), *_cells(self._py_func)]
        ):
            # numba identifies another kernel by a number that is valid in one process only
            return False
        try:
            state = self._state(signature)
        except UnknownSourcesError:
            return False
        folder = self._folder / f"{self._module.removeprefix('frictool.')}-{state.digest}"
        if folder not in _used:
            _used.add(folder)
            _use(folder)
        name = (
            f"{re.sub('[<>]', '', self._py_func.__qualname__)}-{_digest(self._py_func)}"
            f"{self._form}.{sys.implementation.cache_tag}"
        )
        self._impl = _Form(
            _Entry(folder, self._source), name, self._py_func.__code__.co_firstlineno
        )
        self._cache_file = IndexDataCacheFile(str(folder), name, state.digest)  # type: ignore[no-untyped-call]  # as above
        return True

    def _state(self, signature: Any) -> State:
        sources = sources_of(self._folder, self._module, self._source)
        classes = {
            one.instance_class.__module__
            for one in _parts(signature)
            if hasattr(one, "instance_class")
        }
        return sources.state({self._module, *filter(sources.holds, classes)})

    def _reaches_known_sources(self) -> bool:
        """Return True if the module imports the modules of all functions that the kernel calls."""
        sources = sources_of(self._folder, self._module, self._source)
        return reached(self._py_func, sources.holds) <= sources.state({self._module}).modules

    def _claim(self, signature: Any) -> bool:
        """Wait for processes that compile this code, then lock it; return False on failure."""
        words = f"{self._cache_file._index_path}\0{signature}"
        byte = int.from_bytes(hashlib.sha256(words.encode()).digest()[:7], "big")
        if not _lock(self._folder, byte):
            return False
        self._claims[signature] = byte
        return True

    def _forget(self) -> None:
        index = Path(self._cache_file._index_path)
        with writing(self._folder), suppress(OSError):
            index.unlink(missing_ok=True)
            for path in index.parent.glob(f"{index.stem}.*.nbc"):
                path.unlink(missing_ok=True)


_used: set[Path] = set()


def _use(folder: Path) -> None:
    try:
        os.utime(folder)
    except OSError:
        prune_states(folder)


def module_of(function: Any) -> str:
    """Return the name of a function's module; for a script, the name of its file."""
    name = str(function.__module__)
    return Path(function.__code__.co_filename).stem if name == "__main__" else name


def sources_of(folder: Path, module: str, source: str) -> Sources:
    """Return the sources in which imports of the module `module` are looked up."""
    if module.split(".")[0] == PACKAGE.name:
        return _sources(folder, PACKAGE.parent, PACKAGE.name)
    path = Path(source).absolute()
    spread = len(module.split(".")) + (path.name == "__init__.py")
    root = path.parents[spread - 1] if len(path.parents) >= spread else path.parent
    return _sources(folder, root, module.split(".")[0] if INSTALLED & set(root.parts) else "")


@functools.cache
def _sources(folder: Path, root: Path, only: str) -> Sources:
    return Sources(root, folder, only=only)


def _digest(function: Any) -> str:
    """Return a digest of the code, without line numbers, to distinguish functions of one name."""

    def words(code: CodeType, skipped: Any) -> Iterator[Any]:
        yield code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                yield from words(constant, None)
            elif skipped is None or constant != skipped:
                yield (
                    sorted(map(repr, constant))
                    if isinstance(constant, frozenset)
                    else repr(constant)
                )

    return hashlib.sha256(
        repr(list(words(function.__code__, function.__doc__))).encode()
    ).hexdigest()[:8]


def reached(function: Any, is_followed: Callable[[str], bool]) -> set[str]:
    """Return the modules of all functions that a kernel calls through global names and closures.

    is_followed(module): True if the functions of a module are searched.
    """
    left = [function]
    seen = set()
    reached_kernels = set()
    while left:
        one = left.pop()
        one = one.py_func if isinstance(one, Dispatcher) else getattr(one, "_defn", one)
        if not isinstance(one, FunctionType) or id(one) in seen or not is_followed(module_of(one)):
            continue
        seen.add(id(one))
        reached_kernels.add(module_of(one))
        names = _names(one.__code__)
        values = [*(one.__globals__.get(name) for name in names), *_cells(one)]
        modules = [value for value in values if isinstance(value, ModuleType)]
        left += [*values, *(vars(module).get(name) for module in modules for name in names)]
    return reached_kernels


def _names(code: CodeType) -> set[str]:
    nested = [constant for constant in code.co_consts if isinstance(constant, CodeType)]
    return {*code.co_names, *(name for one in nested for name in _names(one))}


def _cells(function: Any) -> list[Any]:
    return [cell.cell_contents for cell in function.__closure__ or ()]


def _parts(signature: Any) -> list[Any]:
    parts = list(getattr(signature, "args", signature))
    for one in parts:
        if isinstance(one, types.BaseTuple):
            parts += getattr(one, "types", None) or [getattr(one, "dtype", None)]
        if isinstance(one, types.Optional):
            parts.append(one.type)
    return parts


# folder -> (process, handle); handles stay open, since closing one would release all its locks
_files: dict[Path, tuple[int, int]] = {}


def _lock(folder: Path, byte: int) -> bool:
    if fcntl is None:
        return False
    try:
        process, handle = _files.get(folder, (0, 0))
        if process != os.getpid():
            handle = os.open(folder / COMPILING, os.O_RDWR | os.O_CREAT, 0o600)
            _files[folder] = (os.getpid(), handle)
        start = time.monotonic()
        is_said = False
        while True:
            try:
                fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
                return True
            except (BlockingIOError, PermissionError):
                if time.monotonic() - start > PATIENCE_S:
                    return False
                if not is_said:
                    notifications.compiling()
                is_said = True
                time.sleep(POLL_S)
    except OSError:  # no locks on this file system
        return False


def _unlock(folder: Path, byte: int) -> None:
    if fcntl is not None:
        with suppress(OSError):
            fcntl.lockf(_files[folder][1], fcntl.LOCK_UN, 1, byte)
