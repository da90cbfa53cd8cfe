"""Reader of recordings: MCAP of any tool, ROS 2 bags (MCAP, db3, folders of parts), ROS 1 bags.

Each topic whose messages contain numbers becomes a table.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from frictool.documents.bench import Layout
from frictool.logs.canonical.mcap_layout import MAGIC
from frictool.logs.open_file import head_of
from frictool.logs.raw_table import RawTable
from frictool.logs.recordings import ros1_bag, ros2_sqlite
from frictool.logs.recordings.mcap_recording import McapRecording
from frictool.logs.recordings.recording import RecordingFile, tables_of
from frictool.logs.recordings.ros1_bag import BagRecording
from frictool.logs.recordings.ros2_sqlite import Db3Recording
from frictool.logs.recordings.split_recording import SplitRecording


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file is an MCAP file or a bag."""
    return head.startswith((MAGIC[:5], ros1_bag.MAGIC, ros2_sqlite.MAGIC))


def tables(path: Path, layout: Layout | None) -> tuple[RawTable, ...]:
    """Return a table for each topic.

    Raises LogError if no topic has numbers, or if the file cannot be read.
    """
    return tables_of(_opened(path), None if layout is None else layout.clock)


def tables_of_parts(paths: Sequence[Path], layout: Layout | None) -> tuple[RawTable, ...]:
    """Return a table for each topic of a recording that is split into the files `paths`, in order.

    Raises LogError if no topic has numbers, or if a file cannot be read.
    """
    return tables_of(
        SplitRecording(paths[0], [_opened(path) for path in paths]),
        None if layout is None else layout.clock,
    )


def _opened(path: Path) -> RecordingFile:
    head = head_of(path)
    if head.startswith(ros1_bag.MAGIC):
        return BagRecording(path)
    return Db3Recording(path) if head.startswith(ros2_sqlite.MAGIC) else McapRecording(path)
