"""Comparison of two installations: sources, numerical libraries and processor."""

from __future__ import annotations

import functools
import hashlib
import os
import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "clarabel")


@dataclass(frozen=True)
class Installation:
    """Versions and processor, on which the results of an installation depend.

    versions: (name, version) of frictool, Python and the numerical libraries.
    processor: CPU for which code is compiled; the last digits of results may depend on the CPU.
    """

    versions: tuple[tuple[str, str], ...]
    processor: str


@functools.cache
def installation() -> Installation:
    """Return the installation of this process.

    The version of frictool includes a digest of the sources, so that edited sources count as
    another version.
    """
    package = f"{_version('frictool')} (sources {_sources()})"
    versions = {
        "frictool": package,
        "python": platform.python_version(),
        **{name: _version(name) for name in LIBRARIES},
    }
    return Installation(tuple(versions.items()), _processor())


def differences(here: Installation, there: Installation) -> str:
    """Return a text with the differing versions of `here` and `there`; "" if all are equal."""
    local, remote = dict(here.versions), dict(there.versions)
    names = [name for name in {**local, **remote} if local.get(name) != remote.get(name)]
    return ", ".join(
        f"{name} {remote.get(name, 'missing')}, here {local.get(name, 'missing')}" for name in names
    )


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def _sources() -> str:
    package = Path(__file__).parent.parent
    seen = hashlib.sha256()
    for folder, folders, files in os.walk(package):
        folders[:] = sorted(set(folders) - {"__pycache__"})
        for name in sorted(name for name in files if name.endswith(".py")):
            source = Path(folder, name)
            seen.update(
                source.relative_to(package).as_posix().encode()
                + b"\0"
                + source.read_bytes()
                + b"\0"
            )
    return seen.hexdigest()[:12]


def _processor() -> str:
    import llvmlite.binding

    return f"{platform.machine()} {llvmlite.binding.get_host_cpu_name()}"
