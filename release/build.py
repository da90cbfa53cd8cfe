"""One build: the source distribution of a tree, and the wheel of that source distribution.

setuptools dates a wheel by SOURCE_DATE_EPOCH, and a source distribution by the clock and the files:
that one is written anew here, sorted, with one date, one owner and one set of permissions.
"""

from __future__ import annotations

import gzip
import os
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from pathlib import Path

from release.source import unpack

BACKEND = (
    "import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])(sys.argv[2])"
)


class Failed(Exception):
    """A build that did not end, or is not what it should be."""


@dataclass(frozen=True)
class Surroundings:
    """Umask, time zone, language and hash seed, none of which may change the built files."""

    umask: int
    zone: str
    language: str
    hash_seed: str


def build(tree: Path, out: Path, epoch: int, surroundings: Surroundings) -> tuple[Path, Path]:
    """(source distribution, wheel) of `tree`, in `out`."""
    before = os.umask(surroundings.umask)
    try:
        return _built(tree, out, epoch, surroundings)
    finally:
        os.umask(before)


def _built(tree: Path, out: Path, epoch: int, surroundings: Surroundings) -> tuple[Path, Path]:
    raw = out / "raw"
    raw.mkdir(parents=True)
    _run("build_sdist", tree, raw, epoch, surroundings)
    (made,) = raw.glob("*.tar.gz")
    sdist = normalised(made, out / made.name, epoch)
    with tarfile.open(sdist) as tar:
        unpack(tar, out / "unpacked")
    (unpacked,) = (out / "unpacked").iterdir()
    _run("build_wheel", unpacked, out, epoch, surroundings)
    (wheel,) = out.glob("*.whl")
    return sdist, wheel


def _run(hook: str, folder: Path, out: Path, epoch: int, surroundings: Surroundings) -> None:
    """A hook of the build backend, in a process of its own; what it writes has permissions, which a
    wheel keeps."""
    environment = os.environ | {
        "SOURCE_DATE_EPOCH": str(epoch),
        "TZ": surroundings.zone,
        "LC_ALL": surroundings.language,
        "PYTHONHASHSEED": surroundings.hash_seed,
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    command = [sys.executable, "-W", "ignore", "-c", BACKEND, hook, str(out.resolve())]
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        umask=0o022,
        check=False,
    )
    if done.returncode != 0:
        raise Failed(f"{hook}: {(done.stderr or done.stdout).strip().splitlines()[-1]}")


def normalised(made: Path, target: Path, epoch: int) -> Path:
    """The same archive, sorted, with one date, one owner, and permissions by what a file is."""
    with (
        tarfile.open(made) as old,
        target.open("wb") as stream,
        gzip.GzipFile("", "wb", 9, stream, mtime=epoch) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as new,
    ):
        for member in sorted(old.getmembers(), key=lambda one: one.name):
            is_open = member.isdir() or bool(member.mode & 0o100)
            plain = tarfile.TarInfo(member.name)
            plain.type, plain.size, plain.mtime, plain.mode = (
                member.type,
                member.size,
                epoch,
                0o755 if is_open else 0o644,
            )
            new.addfile(plain, old.extractfile(member) if member.isfile() else None)
    return target
