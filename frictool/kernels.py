"""How kernels are compiled: numba, once per installation, kept on disk.

numba's own cache looks at the file of the outer function only, so that a kernel goes on calling the old form of one that was
changed in another file. The cache here is a folder named after the digest of every kernel source: another source, another folder.
It lies beside the package, or in the user's cache folder where the installation is read-only; with neither, nothing is kept.
"""

from __future__ import annotations

import functools
import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from frictool import waiting

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


def _source_digest(package: Path) -> str:
    """Digest of the sources of all rooms that hold kernels."""
    seen = hashlib.sha256()
    for room in ROOMS:
        for source in sorted((package / room).glob("*.py")):
            seen.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    return seen.hexdigest()[:16]


def _usable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _cache_folder() -> Path | None:
    """Where compiled kernels are kept, or None where no folder can be written."""
    package = Path(__file__).parent
    if settings.CACHE_DIR:
        return Path(settings.CACHE_DIR)
    name = f"kernels-{_source_digest(package)}"
    user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "frictool")
    places = [package / "__pycache__", *([user] if user.is_absolute() else [])]
    return next((folder / name for folder in places if _usable(folder / name)), None)


FOLDER = _cache_folder()
if FOLDER is not None:
    settings.CACHE_DIR = str(FOLDER)


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
    options = {"cache": FOLDER is not None, "nogil": True, "no_cfunc_wrapper": True, "_nrt": True, "forceinline": False}
    return cast(F, compiler(**options)(function))


def _inner_options(function: Callable[..., Any]) -> dict[str, Any]:
    """Beside each function numba compiles an entry for C, which `pointer` makes where one is needed, and one for Python.

    With many arrays they take longer than the function. A private one (`_name`) has none: only kernels may call it.
    """
    private = function.__name__.startswith("_")
    return {"cache": FOLDER is not None, "forceinline": True, "no_cfunc_wrapper": True, "no_cpython_wrapper": private}


def inner_kernel(function: F) -> F:
    """As `kernel`, copied into its callers: for what an inner loop calls with many arrays, which would be passed word by word."""
    return cast(F, compiler(**_inner_options(function))(function))


def bare_kernel(function: F) -> F:
    """As `inner_kernel`, without numba's runtime: no reference is counted, an atomic instruction at each use of an array.

    Its arrays are its caller's. It makes none, which numba refuses; it must return none, and call nothing that does.
    """
    return cast(F, compiler(**_inner_options(function), _nrt=False)(function))


def part_kernel(function: F) -> F:
    """As `bare_kernel`, but compiled once and called, and by kernels only: for a long part that several have in common."""
    return cast(F, compiler(**{**_inner_options(function), "forceinline": False, "no_cpython_wrapper": True}, _nrt=False)(function))


def inset_kernel(function: F) -> F:
    """As `bare_kernel`, for kernels only, whatever its name: without an entry for Python."""
    return cast(F, compiler(**{**_inner_options(function), "no_cpython_wrapper": True}, _nrt=False)(function))


def parallel_kernel(function: F) -> F:
    """As `kernel`, its `prange` loops over all cores. If none writes what another reads, threads change nothing."""
    return cast(F, numba.njit(cache=FOLDER is not None, parallel=True)(function))


@functools.cache
def pointer(compiled: Callable[..., Any], kind: Any) -> Any:
    """A kernel as a value of a function type (friction/signatures.py): what takes such values is compiled once for all of them."""
    return numba.cfunc(kind.signature, cache=FOLDER is not None)(cast(Any, compiled).py_func)


def is_compiled(module: str, name: str) -> bool:
    """Whether the kernel `name` of a module (the last word of its path) lies compiled on disk."""
    return FOLDER is not None and any(FOLDER.rglob(f"{module}.{name}-*.nbi"))
