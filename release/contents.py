"""Required and unwanted files of a source distribution and of a wheel."""

from __future__ import annotations

import re
import tarfile
import zipfile
from pathlib import Path

from release.build import Failed

UNWANTED = re.compile(r"__pycache__|\.py[cod]$|\.nb[ic]$|(^|/)(build|dist|\.venv|\.git)/")


def check(tree: Path, sdist: Path, wheel: Path) -> None:
    """Raises Failed where a file of `tree` is not in the source distribution, one of the package
    not in the wheel, or anything else is."""
    files = {
        path.relative_to(tree).as_posix()
        for path in tree.rglob("*")
        if path.is_file() and ".egg-info/" not in path.as_posix()
    }
    package = {name for name in files if name.startswith("frictool/")}
    with tarfile.open(sdist) as tar:
        in_source = {name.partition("/")[2] for name in tar.getnames() if name.count("/")}
    with zipfile.ZipFile(wheel) as archive:
        in_wheel = set(archive.namelist())
    _none("the source distribution lacks", files - in_source)
    _none("the wheel lacks", package - in_wheel)
    _none(
        "the wheel has, beside the package,",
        {name for name in in_wheel - package if ".dist-info/" not in name},
    )
    _none(
        "was packed and is no source:",
        {name for name in in_source | in_wheel if UNWANTED.search(name)},
    )


def _none(what: str, names: set[str]) -> None:
    if names:
        few = ", ".join(sorted(names)[:5])
        raise Failed(f"{what} {few}{f' and {len(names) - 5} more' if len(names) > 5 else ''}")
