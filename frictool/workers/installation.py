"""What has to be the same on two machines for their results to be: the sources of this package and
the libraries that compute."""

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
    """versions: name -> version. processor: what the compiler makes code for, where the last bits
    may differ, and no version tells it."""

    versions: tuple[tuple[str, str], ...]
    processor: str


@functools.cache
def installation() -> Installation:
    """Of this process. The package counts by its sources, as one that is worked on keeps its
    version."""
    own = f"{_version('frictool')} (sources {_sources()})"
    versions = {
        "frictool": own,
        "python": platform.python_version(),
        **{name: _version(name) for name in LIBRARIES},
    }
    return Installation(tuple(versions.items()), _processor())


def differences(here: Installation, there: Installation) -> str:
    """What differs, both sides; empty where nothing does."""
    own, other = dict(here.versions), dict(there.versions)
    names = [name for name in {**own, **other} if own.get(name) != other.get(name)]
    return ", ".join(
        f"{name} {other.get(name, 'missing')}, here {own.get(name, 'missing')}" for name in names
    )


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def _sources() -> str:
    """Digest of every source of the package."""
    package, seen = Path(__file__).parent.parent, hashlib.sha256()
    for folder, rooms, files in os.walk(package):
        rooms[:] = sorted(set(rooms) - {"__pycache__"})
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
