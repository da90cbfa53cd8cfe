"""Decorators that compile kernels with numba, once per installation, and keep the code on disk.

Each toolchain has its own folder of compiled code (kernel_folders.py). In this folder, code is
looked up by the sources on which it depends (machine_code_store.py). The folder is in
NUMBA_CACHE_DIR if this variable is set, else in the package. If frictool cannot write there, or if
other users can, the user's cache folder is used instead. If this folder cannot be used either, no
code is kept.
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
from numba.core import event, sigutils, types
from numba.core.ccallback import CFunc

from frictool.runtime import kernel_folders, notifications
from frictool.runtime.machine_code_store import LINKED, KernelStore

F = TypeVar("F", bound=Callable[..., Any])
settings: Any = numba.config
compiler: Any = numba.njit  # untyped, because its signature does not list every option


def toolchain() -> str:
    """Return the versions of compilers and libraries, and the processor, as text."""
    processor = settings.CPU_NAME or llvmlite.binding.get_host_cpu_name()
    libraries = (
        f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, numpy {np.__version__}"
    )
    return f"python {sys.implementation.cache_tag}, {libraries}, {processor}"


def _usable(folder: Path) -> bool:
    try:
        with kernel_folders.restricted_umask():
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def cache_places() -> list[Path]:
    """Return the folders that may contain the kernel folder; the first usable folder is chosen."""
    user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "frictool")
    first = (
        Path(settings.CACHE_DIR).absolute()
        if settings.CACHE_DIR
        else Path(__file__).parents[1] / "__pycache__"
    )
    return [first, *([user] if user.is_absolute() else [])]


def _cache_folder() -> Path | None:
    """Return the folder of compiled kernels and mark it as used; None if no folder can be used.

    If the folder is new, folders of former toolchains are removed. A folder in which other users
    can write is recorded in `UNTRUSTED`, and no code is loaded from it.
    """
    UNTRUSTED.clear()
    name = kernel_folders.folder_name(toolchain())
    for place in cache_places():
        folder = place / name
        is_new = not folder.exists()
        if _usable(folder):
            reason = kernel_folders.untrusted_reason(folder, Path(__file__))
            if reason:
                UNTRUSTED[folder] = reason
                continue
            kernel_folders.mark_used(folder)
            if is_new:
                kernel_folders.prune(place, folder)
            return folder
    return None


UNTRUSTED: dict[Path, str] = {}  # folders that are not loaded -> reason
FOLDER = _cache_folder()


def _declared(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    compiled = compiler(**options)(function)
    if settings.DISABLE_JIT:
        return compiled
    compiled.callee = Callee(function, options)
    compiled.get_call_template = compiled.callee.get_call_template
    compiled.get_overload = compiled.callee.get_overload
    if FOLDER is not None:
        compiled._cache = KernelStore(function, FOLDER)
    return compiled


class Callee:
    """Form of a kernel that other kernels call: code to be linked, without a wrapper for Python.

    This form is compiled separately from the form for Python, and only if another kernel calls the
    kernel.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self._function = function
        self._options = {**options, "no_cfunc_wrapper": True, "no_cpython_wrapper": True}

    @functools.cached_property
    def dispatcher(self) -> Any:
        """Return numba's dispatcher of this form."""
        from frictool.runtime.called_kernels import LinkedCompiler  # loads numba's compiler

        made = compiler(**self._options, pipeline_class=LinkedCompiler)(self._function)
        if FOLDER is not None:
            made._cache = KernelStore(self._function, FOLDER, form=LINKED)
        return made

    def get_call_template(self, arguments: Any, named: dict[str, Any]) -> Any:
        """Resolve a kernel's call as numba does, with general types in place of constant values.

        With the types of constants, numba would compile the called kernel for each value
        separately.
        """
        return self.dispatcher.get_call_template(
            [_general(one) for one in arguments],
            {name: _general(one) for name, one in named.items()},
        )

    def get_overload(self, signature: Any) -> Any:
        """Return numba's key of the compiled code for a signature."""
        return self.dispatcher.get_overload(signature)


def _general(kind: Any) -> Any:
    """Return the type of an argument; a constant integer or truth value gets its general type."""
    is_constant = isinstance(kind, (types.IntegerLiteral, types.BooleanLiteral))
    return kind.literal_type if is_constant else kind


class _Wait(event.Listener):
    """Listener of numba for compilations; loading from disk does not call the listener."""

    def on_start(self, event: Any) -> None:
        notifications.compiling()

    def on_end(self, event: Any) -> None:
        """Release the lock after a failure; after a success `save_overload` releases the lock."""
        store = event.data["dispatcher"]._cache
        # the exception decides: numba 0.68 has is_failed the wrong way round
        if event._exc_details is not None and isinstance(store, KernelStore):
            store.release()


event.register("numba:compile", _Wait())  # type: ignore[no-untyped-call]  # numba has no types


def kernel(function: F) -> F:
    """Compile a function of floats and arrays on its first call.

    Arithmetic is IEEE, in the order written. The function uses no Python objects and releases the
    global interpreter lock. References to arrays are counted, and the function is not inlined into
    callers. These two options are set explicitly. Without this, a kernel that is first called from
    an `inner_kernel` or a `bare_kernel` would inherit the options of its caller.
    """
    return cast(
        F,
        _declared(
            function, {"nogil": True, "no_cfunc_wrapper": True, "_nrt": True, "forceinline": False}
        ),
    )


INNER = {"forceinline": True, "no_cfunc_wrapper": True}  # options of kernels for inner loops
PART = {**INNER, "forceinline": False, "_nrt": False}  # options of long functions inside kernels


def inner_kernel(function: F) -> F:
    """Compile a function as `kernel` does, and inline it into its callers; for inner loops."""
    return cast(F, _declared(function, INNER))


def bare_kernel(function: F) -> F:
    """Compile a function as `inner_kernel` does, but without counting references to arrays.

    Counting costs an atomic instruction at each use of an array. The function may use only arrays
    of its caller: it must neither create an array, which numba refuses, nor return an array, nor
    call a function that returns an array.
    """
    return cast(F, _declared(function, {**INNER, "_nrt": False}))


def part_kernel(function: F) -> F:
    """Compile a function as `bare_kernel` does, without inlining; for long shared functions."""
    return cast(F, _declared(function, PART))


def summing_kernel(function: F) -> F:
    """Compile a function as `part_kernel` does, but add the terms of sums in any order.

    Sums of long arrays are several times as fast as in a fixed order. Their last digits depend on
    the processor, so that the caller must allow for rounding errors. The last digits of the bounds
    that `prove` computes over a parameter box may therefore differ between computers.
    """
    return cast(F, _declared(function, {**PART, "fastmath": {"reassoc"}}))


def parallel_kernel(function: F) -> F:
    """Compile a function as `kernel` does, with `prange` loops distributed to all cores.

    The result does not depend on the number of threads if no iteration writes a value that another
    iteration reads.
    """
    return cast(F, _declared(function, {"parallel": True}))


@functools.cache
def function_pointer(compiled: Callable[..., Any], kind: Any) -> Any:
    """Return a kernel as a value of the function type `kind` (friction/kernel_signatures.py).

    A kernel with an argument of a function type is compiled only once for all functions of this
    type.
    """
    signature: Any = cast(Any, sigutils).normalize_signature(kind.signature)
    # not numba.cfunc, whose cache cannot be guarded against stale sources
    made: Any = CFunc(cast(Any, compiled).py_func, signature, locals={}, options={})
    if FOLDER is not None:
        made._cache = KernelStore(cast(Any, compiled).py_func, FOLDER)
    try:
        made.compile()
    finally:
        if isinstance(made._cache, KernelStore):
            made._cache.release()
    return made


def is_compiled(function: Callable[..., Any]) -> bool:
    """Return True if a kernel's code is on disk for at least one set of argument types."""
    store = getattr(function, "_cache", None)
    return isinstance(store, KernelStore) and store.is_kept()
