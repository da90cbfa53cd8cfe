"""Writer of streams as channel groups of an MDF 4.10 file, with asammdf (extra `mdf`).

The start time of the file is the clock time at time 0 of the log. The start time is 1970-01-01 if
the log has no clock.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO
from xml.sax.saxutils import escape

from frictool.logs.canonical.mcap_layout import EPOCH_KEY, TIME
from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import TIME_NAME, OutgoingStream
from frictool.logs.provenance import PROVENANCE

VERSION = "4.10"


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Write all streams to a temporary file, then copy this file to `target`."""
    from asammdf import MDF

    with (
        tempfile.TemporaryDirectory(prefix="frictool-") as folder,
        MDF(version=VERSION, temporary_folder=folder) as file,
    ):
        for index, stream in enumerate(streams):
            _append(file, index, stream)
        file.header.abs_time = max(0, int(notes.get(TIME, {}).get(EPOCH_KEY, 0)))
        file.file_history.append(_history(notes))
        # compression 2: transposed and deflated
        written = file.save(Path(folder, "log.mf4"), compression=2, add_history_block=False)
        with written.open("rb") as saved:
            shutil.copyfileobj(saved, target, 1 << 20)


def _append(file: Any, index: int, stream: OutgoingStream) -> None:
    """Write a stream as a channel group.

    asammdf requires names and units with the first block, and plain numbers with all later blocks.
    """
    from asammdf import Signal

    for number, (time, *columns) in enumerate(stream.blocks()):
        if number:
            file.extend(index, [(time, None), *((column, None) for column in columns)])
            continue
        named = zip(stream.head.fields, stream.head.units, columns, strict=True)
        signals = [Signal(column, time, name=name, unit=unit) for name, unit, column in named]
        file.append(signals, acq_name=stream.head.topic, common_timebase=True)
        file.groups[index].channels[0].name = TIME_NAME


def _history(notes: Notes) -> Any:
    from asammdf.blocks.v4_blocks import FileHistory

    history = FileHistory(abs_time=0)
    history.abs_time = 0
    made = escape("; ".join(f"{key}: {text}" for key, text in notes.get(PROVENANCE, {}).items()))
    history.comment = (
        f"<FHcomment><TX>{made}</TX><tool_id>frictool</tool_id>"
        "<tool_vendor>frictool</tool_vendor></FHcomment>"
    )
    return history
