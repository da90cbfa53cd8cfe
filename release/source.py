"""Source of a release: the last commit of a clone or an unpacked distribution, and its date.

Generated files are left out.
"""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import tarfile
from pathlib import Path

MADE = (
    ".venv",
    "build",
    "dist",
    "__pycache__",
    "*.egg-info",
    ".git",
    ".*_cache",
    ".hypothesis",
    "PKG-INFO",
    "setup.cfg",
)


def is_clone(root: Path) -> bool:
    """Return True if `root` is the top of a git checkout."""
    return (root / ".git").exists()


def source(root: Path, target: Path) -> Path:
    """A copy in `target` of what is committed in `root`; where that is no clone, of all that was
    not made there."""
    if is_clone(root):
        archive = subprocess.run(
            ["git", "-C", str(root), "archive", "--format=tar", "HEAD"],
            capture_output=True,
            check=True,
        ).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            unpack(tar, target)
    else:
        shutil.copytree(root, target, ignore=shutil.ignore_patterns(*MADE))
    return target


def epoch_of(root: Path) -> int:
    """SOURCE_DATE_EPOCH where it is set, else the date of the last commit, or of the source
    distribution's own metadata [s]."""
    given = os.environ.get("SOURCE_DATE_EPOCH")
    if given:
        return int(given)
    if is_clone(root):
        return int(
            subprocess.run(
                ["git", "-C", str(root), "log", "-1", "--format=%ct"],
                capture_output=True,
                text=True,
                check=True,
            ).stdout
        )
    return int((root / "PKG-INFO").stat().st_mtime)


def unpack(tar: tarfile.TarFile, target: Path) -> None:
    """All of an archive of our own. Python has the filter since 3.11.4, and since 3.12 warns where
    it is not named."""
    if hasattr(tarfile, "data_filter"):
        tar.extractall(target, filter="data")
    else:
        tar.extractall(target)
