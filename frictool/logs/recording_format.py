"""Recordings of messages: MCAP of any tool, ROS 2 bags (MCAP, db3, folders of parts), ROS 1 bags. Each topic with numbers is a table."""

from __future__ import annotations

from pathlib import Path

from frictool.documents.bench import Layout
from frictool.logs.mcap_layout import MAGIC
from frictool.logs.recorded_mcap import McapRecording
from frictool.logs.recording import tables_of
from frictool.logs.table import Table


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file is an MCAP or a bag."""
    return head.startswith(MAGIC[:5])


def tables(path: Path, layout: Layout | None) -> tuple[Table, ...]:
    """A table for each topic that carries numbers. Raises LogError where there is none, or where the file cannot be read."""
    return tables_of(McapRecording(path), getattr(layout, "clock", None))
