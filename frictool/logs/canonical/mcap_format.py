"""The canonical log, MCAP: writing (mcap_writer.py) and reading (mcap_reader.py) of one layout (mcap_layout.py)."""

from __future__ import annotations

from frictool.logs.canonical.mcap_reader import read_mcap
from frictool.logs.canonical.mcap_writer import write_mcap

__all__ = ["read_mcap", "write_mcap"]
