"""Recordings of messages: MCAP of any tool, ROS 2 bags (MCAP, db3, folders of parts), ROS 1 bags. Each topic with numbers is a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from frictool.documents.bench import Layout
from frictool.logs.canonical.mcap_layout import MAGIC
from frictool.logs.recordings import recorded_bag, recorded_db3
from frictool.logs.recordings.recorded_bag import BagRecording
from frictool.logs.recordings.recorded_db3 import Db3Recording
from frictool.logs.recordings.recorded_mcap import McapRecording
from frictool.logs.recordings.recorded_parts import SplitRecording
from frictool.logs.recordings.recording import Container, tables_of
from frictool.logs.source import head_of
from frictool.logs.table import Table


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is an MCAP or a bag."""
    return head.startswith((MAGIC[:5], recorded_bag.MAGIC, recorded_db3.MAGIC))


def tables(path: Path, layout: Layout | None) -> tuple[Table, ...]:
    """A table for each topic that carries numbers. Raises LogError where there is none, or where the file cannot be read."""
    return tables_of(_opened(path), None if layout is None else layout.clock)


def tables_of_parts(paths: Sequence[Path], layout: Layout | None) -> tuple[Table, ...]:
    """The same of the parts of one recording, in their order."""
    return tables_of(SplitRecording(paths[0], [_opened(path) for path in paths]), None if layout is None else layout.clock)


def _opened(path: Path) -> Container:
    head = head_of(path)
    if head.startswith(recorded_bag.MAGIC):
        return BagRecording(path)
    return Db3Recording(path) if head.startswith(recorded_db3.MAGIC) else McapRecording(path)
