"""How kernels are compiled: numba, once per installation, kept on disk.

numba's own cache looks at the file of the outer function only, so that a kernel goes on calling the old form of one that was
changed in another file. The cache here is a folder named after the digest of every kernel source and of what compiles them: another
source, another folder (kernel_cache.py). It lies where NUMBA_CACHE_DIR says, else beside the package. Where that cannot be written, or
others can write there, it is the user's cache folder; with none of them, nothing is kept.
"""

from __future__ import annotations

import functools
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite.binding
import numba
from numba.core import event, sigutils
from numba.core.ccallback import CFunc

from frictool import kernel_cache, waiting

IDENTIFY = tuple(f"identify/{room}" for room in ("breakaway", "estimators", "presliding", "regression", "rows"))
ROOMS = (
    "friction",
    "control",
    "plant",
    "plant/mechanism",
    "engine",
    "engine/mechanism",
    *IDENTIFY,
    "logs/kernels",
    "observe/kernels",
    "observe/wear",
)
F = TypeVar("F", bound=Callable[..., Any])
settings: Any = numba.config
compiler: Any = numba.njit  # its own signature does not list every option


def toolchain() -> str:
    """What compiles the kernels, and for which processor."""
    processor = settings.CPU_NAME or llvmlite.binding.get_host_cpu_name()
    return f"python {sys.implementation.cache_tag}, numba {numba.__version__}, llvmlite {llvmlite.__version__}, {processor}"


def _usable(folder: Path) -> bool:
    try:
        with kernel_cache.private():
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def places() -> list[Path]:
    """Return where the folder of kernels may lie; the first that is trusted and can be written is used."""
    user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "frictool")
    first = Path(settings.CACHE_DIR).absolute() if settings.CACHE_DIR else Path(__file__).parent / "__pycache__"
    return [first, *([user] if user.is_absolute() else [])]


def _cache_folder() -> Path | None:
    """Return the folder of compiled kernels, held for this process; None where no folder can be used.

    Whoever makes it anew removes what former states left over. A folder in which others can write is not loaded (`UNTRUSTED`).
    """
    UNTRUSTED.clear()
    name = kernel_cache.folder_name(Path(__file__).parent, ROOMS, toolchain())
    for place in places():
        folder = place / name
        is_new = not folder.exists()
        if _usable(folder):
            reason = kernel_cache.distrust(folder, Path(__file__))
            if reason:
                UNTRUSTED[folder] = reason
                continue
            kernel_cache.hold(folder)
            if is_new:
                kernel_cache.prune(place, folder)
            return folder
    return None


UNTRUSTED: dict[Path, str] = {}  # folders that are not loaded -> why
FOLDER = _cache_folder()


@contextmanager
def _kept_here() -> Iterator[None]:
    """numba asks where to keep a function when it is declared; what others compile is kept where they want it."""
    before, settings.CACHE_DIR = settings.CACHE_DIR, str(FOLDER or "")
    try:
        yield
    finally:
        settings.CACHE_DIR = before


def _declared(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """A function for numba to compile at its first call, and to keep."""
    with _kept_here():
        compiled = compiler(**options, cache=FOLDER is not None)(function)
    if FOLDER is not None and not settings.DISABLE_JIT:
        kernel_cache.guard(compiled._cache, FOLDER)
    return compiled


class _Wait(event.Listener):
    """Hears what is compiled anew, and nothing of what comes from the disk."""

    def on_start(self, event: Any) -> None:
        waiting.compiling()

    def on_end(self, event: Any) -> None:
        """Whoever waited sees that it goes on."""


event.register("numba:compile", _Wait())  # type: ignore[no-untyped-call]  # numba has no types


def kernel(function: F) -> F:
    """Compiles a function of floats and arrays on its first call: no Python objects, IEEE arithmetic in the order written.

    Other threads go on while it runs. References are counted and nothing is copied into callers, even where an `inner_kernel` or a
    `bare_kernel` calls it first, whose options it would inherit.
    """
    return cast(F, _declared(function, {"nogil": True, "no_cfunc_wrapper": True, "_nrt": True, "forceinline": False}))


def _inner_options(function: Callable[..., Any]) -> dict[str, Any]:
    """Beside each function numba compiles an entry for C, which `pointer` makes where one is needed, and one for Python.

    With many arrays they take longer than the function. A private one (`_name`) has none: only kernels may call it.
    """
    private = function.__name__.startswith("_")
    return {"forceinline": True, "no_cfunc_wrapper": True, "no_cpython_wrapper": private}


def inner_kernel(function: F) -> F:
    """As `kernel`, copied into its callers: for what an inner loop calls with many arrays, which would be passed word by word."""
    return cast(F, _declared(function, _inner_options(function)))


def bare_kernel(function: F) -> F:
    """As `inner_kernel`, without numba's runtime: no reference is counted, an atomic instruction at each use of an array.

    Its arrays are its caller's. It makes none, which numba refuses; it must return none, and call nothing that does.
    """
    return cast(F, _declared(function, {**_inner_options(function), "_nrt": False}))


def part_kernel(function: F) -> F:
    """As `bare_kernel`, but compiled once and called, and by kernels only: for a long part that several have in common."""
    return cast(F, _declared(function, {**_inner_options(function), "forceinline": False, "no_cpython_wrapper": True, "_nrt": False}))


def inset_kernel(function: F) -> F:
    """As `bare_kernel`, for kernels only, whatever its name: without an entry for Python."""
    return cast(F, _declared(function, {**_inner_options(function), "no_cpython_wrapper": True, "_nrt": False}))


def parallel_kernel(function: F) -> F:
    """As `kernel`, its `prange` loops over all cores. If none writes what another reads, threads change nothing."""
    return cast(F, _declared(function, {"parallel": True}))


@functools.cache
def pointer(compiled: Callable[..., Any], kind: Any) -> Any:
    """A kernel as a value of a function type (friction/signatures.py): what takes such values is compiled once for all of them."""
    signature: Any = cast(Any, sigutils).normalize_signature(kind.signature)
    made: Any = CFunc(cast(Any, compiled).py_func, signature, locals={}, options={})  # numba.cfunc, whose cache could not be guarded
    if FOLDER is not None:
        with _kept_here():
            made.enable_caching()
        kernel_cache.guard(made._cache, FOLDER)
    made.compile()
    return made


def is_compiled(module: str, name: str) -> bool:
    """Whether the kernel `name` of a module (the last word of its path) lies compiled on disk."""
    return FOLDER is not None and any(FOLDER.rglob(f"{module}.{name}-*.nbi"))
