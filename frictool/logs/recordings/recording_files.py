"""Grouping of files into recordings.

Recorders split long recordings into numbered files. A ROS 2 bag is a folder with such files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import yaml
from yaml.constructor import SafeConstructor

from frictool.documents.document_text import read_text
from frictool.documents.name_list import listed
from frictool.documents.yaml_parser import compose
from frictool.errors import InputFileError, LogError
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.formats import FORMATS

METADATA = "metadata.yaml"  # file in the folder of a ROS 2 bag
ROOT = "rosbag2_bagfile_information"
_NUMBERED = re.compile(r"(.+_)(\d+)")


def sources(paths: Sequence[Path]) -> list[tuple[Path, ...]]:
    """Return the recordings that the files and folders contain; a recording is a tuple of files.

    Files with names such as `run_0.mcap` and `run_1.mcap` are parts of one recording if their
    numbers begin at 0 and have no gaps. They must be listed without other files between them, in
    any order. Any other file, and any canonical log, is a recording by itself. Raises LogError if a
    folder is not a ROS 2 bag.
    """
    recordings: list[tuple[Path, ...]] = []
    left = list(paths)
    while left:
        count = next((n for n in range(len(left), 1, -1) if are_parts(left[:n])), 1)
        taken, left = left[:count], left[count:]
        if count > 1 and not is_canonical(taken[0]):
            recordings.append(tuple(sorted(taken, key=_number)))
        else:
            recordings += [tuple(parts_of(path)) if path.is_dir() else (path,) for path in taken]
    return recordings


def parts_of(folder: Path) -> list[Path]:
    """Return the files of a ROS 2 bag in order.

    Raises LogError if the folder is not a ROS 2 bag, or if the bag is compressed or lacks files.
    """
    if not (folder / METADATA).exists():
        raise LogError(
            folder,
            "is a directory; expected: a log file, or the folder of a ROS 2 bag, "
            f"which has a {METADATA}",
        )
    try:
        metadata = SafeConstructor().construct_document(compose(read_text(folder / METADATA)))
        about = metadata[ROOT]
        names = [str(name) for name in about["relative_file_paths"]]
        compressed = str(about.get("compression_mode") or "").upper() not in ("", "NONE")
    except InputFileError as error:
        raise LogError(folder, f"is not a ROS 2 bag: {error}") from None
    except (yaml.YAMLError, ValueError, KeyError, TypeError, AttributeError):
        raise LogError(
            folder / METADATA, f"names no files; expected: {ROOT} with relative_file_paths"
        ) from None
    if compressed:
        raise LogError(
            folder,
            "is a compressed bag; unpack it with `ros2 bag convert`, or its files with `zstd -d`",
        )
    missing = [name for name in names if not (folder / Path(name).name).is_file()]
    if missing or not names:
        raise LogError(
            folder,
            f"lacks the files {listed(missing)}, which {METADATA} names"
            if names
            else f"has no files: {METADATA} names none",
        )
    return [folder / Path(name).name for name in names]


def are_parts(paths: Sequence[Path]) -> bool:
    """Return True if the files have the names of the parts of one split recording."""
    matches = [_NUMBERED.fullmatch(path.stem) for path in paths]
    alike = (
        len(
            {
                (path.parent, path.suffix, match[1] if match else "")
                for path, match in zip(paths, matches, strict=True)
            }
        )
        == 1
    )
    return (
        alike
        and paths[0].suffix in FORMATS[0].suffixes
        and all(matches)
        and sorted(map(_number, paths)) == list(range(len(paths)))
    )


def _number(path: Path) -> int:
    match = _NUMBERED.fullmatch(path.stem)
    return -1 if match is None else int(match[2])
