"""Recordings of messages: MCAP of any tool, ROS 2 bags (MCAP, db3, folders of parts), ROS 1 bags. Each topic with numbers is a table."""

from __future__ import annotations

from pathlib import Path

from frictool.documents.bench import Layout
from frictool.logs import recorded_bag, recorded_db3
from frictool.logs.mcap_layout import MAGIC
from frictool.logs.recorded_bag import BagRecording
from frictool.logs.recorded_db3 import Db3Recording
from frictool.logs.recorded_mcap import McapRecording
from frictool.logs.recorded_parts import METADATA, SplitRecording, parts_of
from frictool.logs.recording import Container, tables_of
from frictool.logs.source import head_of
from frictool.logs.table import Table


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is an MCAP or a bag, or the folder of one."""
    return head.startswith((MAGIC[:5], recorded_bag.MAGIC, recorded_db3.MAGIC)) or (path.is_dir() and (path / METADATA).exists())


def tables(path: Path, layout: Layout | None) -> tuple[Table, ...]:
    """A table for each topic that carries numbers. Raises LogError where there is none, or where the file cannot be read."""
    container = SplitRecording(path, [_opened(part) for part in parts_of(path)]) if path.is_dir() else _opened(path)
    return tables_of(container, None if layout is None else layout.clock)


def _opened(path: Path) -> Container:
    head = head_of(path)
    if head.startswith(recorded_bag.MAGIC):
        return BagRecording(path)
    return Db3Recording(path) if head.startswith(recorded_db3.MAGIC) else McapRecording(path)
