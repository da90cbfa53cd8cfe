"""A recording that was split: its parts, in their order, as one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import yaml

from frictool.errors import LogError
from frictool.logs.messages import Messages
from frictool.logs.recording import Container, Gap, Topic
from frictool.logs.table import listed

METADATA = "metadata.yaml"  # beside the parts of a ROS 2 bag
ROOT = "rosbag2_bagfile_information"
_NUMBERED = re.compile(r"(.*?)_?(\d+)")


class SplitRecording:
    """Parts of one recording, opened (a `Container`). A part may lack topics that others have."""

    def __init__(self, path: Path, parts: list[Container]) -> None:
        self.source, self._parts = str(path), parts
        self.size = sum(part.size for part in parts)
        self.topics: dict[str, Topic] = {}
        for part in parts:
            for name, topic in part.topics.items():
                known = self.topics.setdefault(name, topic)
                if known.kind != topic.kind:
                    raise LogError(
                        part.source, f"topic {name} carries {topic.kind}, and {known.kind} in another part; are these one recording?"
                    )
                if not known.paths:
                    self.topics[name] = topic

    def messages(self, topic: str) -> Iterator[tuple[Messages | Gap, int]]:
        """See `Container`."""
        before = 0
        for part in self._parts:
            for piece, done in part.messages(topic) if topic in part.topics else ():
                named = Gap(f"{Path(part.source).name} {piece.reason}", piece.samples) if isinstance(piece, Gap) else piece
                yield named, before + done
            before += part.size


def parts_of(folder: Path) -> list[Path]:
    """The files of a ROS 2 bag, which is a folder, in their order. Raises LogError where the folder is none."""
    try:
        found = yaml.safe_load((folder / METADATA).read_text(encoding="utf-8"))
        about = found[ROOT]
        names = [str(name) for name in about["relative_file_paths"]]
        compressed = str(about.get("compression_mode") or "").upper() not in ("", "NONE")
    except OSError as error:
        raise LogError(folder, f"is a folder and no ROS 2 bag: {METADATA} cannot be read: {error.strerror or error}") from None
    except (yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError, AttributeError, RecursionError):
        raise LogError(folder / METADATA, f"names no files; expected: {ROOT} with relative_file_paths") from None
    if compressed:
        raise LogError(folder, "is a compressed bag; unpack it with `ros2 bag convert`, or its files with `zstd -d`")
    missing = [name for name in names if not (folder / Path(name).name).is_file()]
    if missing or not names:
        raise LogError(folder, f"lacks the files {listed(missing)}, which {METADATA} names" if names else f"has no files by its {METADATA}")
    return [folder / Path(name).name for name in names]


def are_parts(paths: list[Path]) -> bool:
    """Whether files are by their names the parts of one split recording: `run_0.mcap`, `run_1.mcap`, ..."""
    matches = [_NUMBERED.fullmatch(path.stem) for path in paths]
    if len(paths) < 2 or not all(matches):
        return False
    numbers = [int(match[2]) for match in matches if match]
    alike = len({(path.parent, path.suffix, match[1]) for path, match in zip(paths, matches, strict=True) if match}) == 1
    return alike and sorted(numbers) == list(range(min(numbers), min(numbers) + len(numbers)))
