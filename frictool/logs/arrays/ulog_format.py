"""Reader of ULog, the log format of PX4, with pyulog (extra `ulog`).

Each topic (such as `esc_status`) is a table. A second instance of a topic is a separate table with
a numbered name (such as `esc_status.1`). The field `timestamp` gives the times of the rows.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from frictool.errors import LogError
from frictool.logs.arrays.library_series import SeriesTable, loaded
from frictool.logs.arrays.reader_process import LibraryTable, open_guarded
from frictool.logs.open_file import open_log
from frictool.logs.raw_table import RawTable

if TYPE_CHECKING:
    from frictool.documents.bench import Layout

MAGIC = b"ULog\x01\x12\x35"
TIMESTAMP = "timestamp"  # us
HEADER = 16  # bytes before the first message
MESSAGE = struct.Struct("<HB")  # size and type before the content of a message


def sniff(head: bytes, path: Path) -> bool:
    """Return True if the file begins with the signature of ULog."""
    return head.startswith(MAGIC)


def tables(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return a table for each topic; raise LogError if the file has no data message."""
    open_log(path).close()
    return open_guarded(path, _open)


def _open(path: Path) -> Sequence[LibraryTable]:
    from pyulog import ULog

    log = ULog(str(path))
    damage = None
    if log.file_corruption:
        damage = "its messages are damaged"
    elif not log.has_data_appended and _is_cut(path):
        damage = (
            "its last message is incomplete: the file is cut off, or its logger was switched off"
        )
    tables = []
    for topic in log.data_list:
        rows = len(topic.data.get(TIMESTAMP, ()))
        columns = {name: loaded(values) for name, values in topic.data.items() if name != TIMESTAMP}
        if rows and columns:
            times = np.asarray(topic.data[TIMESTAMP], np.int64) * 1000
            tables.append(
                SeriesTable(
                    source=str(path),
                    topic=topic.name if topic.multi_id == 0 else f"{topic.name}.{topic.multi_id}",
                    columns=columns,
                    units=dict.fromkeys(columns),
                    others={},
                    clock=TIMESTAMP,
                    rows=rows,
                    times=loaded(times),
                    damage=damage,
                )
            )
    if not tables:
        raise LogError(path, f"contains no data messages{'; it is damaged' if damage else ''}")
    return tables


def _is_cut(path: Path) -> bool:
    data = path.read_bytes()
    at = HEADER
    while at + MESSAGE.size <= len(data):
        size, _ = MESSAGE.unpack_from(data, at)
        at += MESSAGE.size + size
    return at != len(data)
