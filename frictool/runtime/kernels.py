"""How kernels are compiled: numba, once per installation, kept on disk.

The folder that they are kept in belongs to what compiles them (kernel_cache.py); in it, code is
found by the sources that it depends on (kernel_store.py). It lies where NUMBA_CACHE_DIR says, else
beside the package. If that place cannot be written, or others can write there, the user's cache
folder is used; without one, nothing is kept.
"""

from __future__ import annotations

import functools
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite.binding
import numba
import numpy as np
from numba.core import event, sigutils
from numba.core.ccallback import CFunc

from frictool.runtime import kernel_cache, notifications
from frictool.runtime.kernel_store import KernelStore

F = TypeVar("F", bound=Callable[..., Any])
settings: Any = numba.config
compiler: Any = numba.njit  # its own signature does not list every option


def toolchain() -> str:
    """What compiles the kernels, and for which processor."""
    processor = settings.CPU_NAME or llvmlite.binding.get_host_cpu_name()
    libraries = (
        f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, numpy {np.__version__}"
    )
    return f"python {sys.implementation.cache_tag}, {libraries}, {processor}"


def _usable(folder: Path) -> bool:
    try:
        with kernel_cache.restricted_umask():
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def cache_places() -> list[Path]:
    """Return where the folder of kernels may lie; the first that is trusted and can be written is
    used."""
    user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "frictool")
    first = (
        Path(settings.CACHE_DIR).absolute()
        if settings.CACHE_DIR
        else Path(__file__).parents[1] / "__pycache__"
    )
    return [first, *([user] if user.is_absolute() else [])]


def _cache_folder() -> Path | None:
    """Return the folder of compiled kernels, held for this process; None where no folder can be
    used.

    Whoever makes it anew removes what former states left over. A folder in which others can write
    is not loaded (`UNTRUSTED`).
    """
    UNTRUSTED.clear()
    name = kernel_cache.folder_name(toolchain())
    for place in cache_places():
        folder = place / name
        is_new = not folder.exists()
        if _usable(folder):
            reason = kernel_cache.untrusted_reason(folder, Path(__file__))
            if reason:
                UNTRUSTED[folder] = reason
                continue
            kernel_cache.mark_used(folder)
            if is_new:
                kernel_cache.prune(place, folder)
            return folder
    return None


UNTRUSTED: dict[Path, str] = {}  # folders that are not loaded -> why
FOLDER = _cache_folder()


def _declared(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """A function for numba to compile at its first call, and to keep."""
    compiled = compiler(**options)(function)
    if FOLDER is not None and not settings.DISABLE_JIT:
        compiled._cache = KernelStore(function, FOLDER)
    return compiled


class _Wait(event.Listener):
    """Listener to what is compiled anew; it hears nothing of what comes from the disk."""

    def on_start(self, event: Any) -> None:
        notifications.compiling()

    def on_end(self, event: Any) -> None:
        """Let other processes compile what failed here; what succeeded is kept first."""
        store = event.data["dispatcher"]._cache
        if event._exc_details is not None and isinstance(
            store, KernelStore
        ):  # numba 0.68 has is_failed the wrong way round
            store.release()


event.register("numba:compile", _Wait())  # type: ignore[no-untyped-call]  # numba has no types


def kernel(function: F) -> F:
    """Compiles a function of floats and arrays on its first call: no Python objects, IEEE
    arithmetic in the order written.

    Other threads go on while it runs. References are counted and nothing is copied into callers,
    even where an `inner_kernel` or a `bare_kernel` calls it first, whose options it would inherit.
    """
    return cast(
        F,
        _declared(
            function, {"nogil": True, "no_cfunc_wrapper": True, "_nrt": True, "forceinline": False}
        ),
    )


def _inner_options(function: Callable[..., Any]) -> dict[str, Any]:
    """Beside each function numba compiles an entry for C, which `pointer` makes where one is
    needed, and one for Python.

    With many arrays they take longer than the function. A private one (`_name`) has none: only
    kernels may call it.
    """
    private = function.__name__.startswith("_")
    return {"forceinline": True, "no_cfunc_wrapper": True, "no_cpython_wrapper": private}


def inner_kernel(function: F) -> F:
    """As `kernel`, copied into its callers: for what an inner loop calls with many arrays, which
    would be passed word by word."""
    return cast(F, _declared(function, _inner_options(function)))


def bare_kernel(function: F) -> F:
    """As `inner_kernel`, without numba's runtime: no reference is counted, an atomic instruction at
    each use of an array.

    Its arrays are its caller's. It makes none, which numba refuses; it must return none, and call
    nothing that does.
    """
    return cast(F, _declared(function, {**_inner_options(function), "_nrt": False}))


def part_kernel(function: F) -> F:
    """As `bare_kernel`, but compiled once and called, and by kernels only: for a long part that
    several have in common."""
    return cast(
        F,
        _declared(
            function,
            {
                **_inner_options(function),
                "forceinline": False,
                "no_cpython_wrapper": True,
                "_nrt": False,
            },
        ),
    )


def inset_kernel(function: F) -> F:
    """As `bare_kernel`, for kernels only, whatever its name: without an entry for Python."""
    return cast(
        F,
        _declared(
            function, {**_inner_options(function), "no_cpython_wrapper": True, "_nrt": False}
        ),
    )


def parallel_kernel(function: F) -> F:
    """As `kernel`, its `prange` loops over all cores. If none writes what another reads, threads
    change nothing."""
    return cast(F, _declared(function, {"parallel": True}))


@functools.cache
def function_pointer(compiled: Callable[..., Any], kind: Any) -> Any:
    """A kernel as a value of a function type (friction/kernel_signatures.py): what takes such
    values is compiled once for all of them."""
    signature: Any = cast(Any, sigutils).normalize_signature(kind.signature)
    made: Any = CFunc(
        cast(Any, compiled).py_func, signature, locals={}, options={}
    )  # numba.cfunc, whose cache could not be guarded
    if FOLDER is not None:
        made._cache = KernelStore(cast(Any, compiled).py_func, FOLDER)
    try:
        made.compile()
    finally:
        if isinstance(made._cache, KernelStore):
            made._cache.release()
    return made


def is_compiled(function: Callable[..., Any]) -> bool:
    """Return whether a kernel lies compiled on disk, for any types of arguments."""
    store = getattr(function, "_cache", None)
    return isinstance(store, KernelStore) and store.is_kept()
