"""Formats of raw bench files, detected from the content and never from the name.

A format is one module, imported when it is needed. `sniff(head, path)` says whether a file has this
format, from its first HEAD_BYTES bytes. `tables(path, layout)` opens the file and returns one table
for each of its time bases, without reading rows.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol, cast

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.open_file import head_of
from frictool.logs.recordings.recording_format import tables_of_parts
from frictool.logs.table import RawTable


class Format(NamedTuple):
    """Log file format: its name in messages, and the module that reads it."""

    name: str
    module: str


# in the order of detection; the text format accepts any file without a NUL character
FORMATS = (
    Format("recordings (MCAP, ROS bags)", "frictool.logs.recordings.recording_format"),
    Format("MATLAB", "frictool.logs.arrays.mat_format"),
    Format("MATLAB 7.3", "frictool.logs.arrays.mat73_format"),
    Format("MDF", "frictool.logs.arrays.mdf_format"),
    Format("Parquet", "frictool.logs.arrays.parquet_format"),
    Format("NumPy", "frictool.logs.arrays.npz_format"),
    Format("text with columns (CSV)", "frictool.logs.text.csv_format"),
)

# files that are not logs but may hold one: first bytes -> message
PACKED = {
    b"\x1f\x8b": "is packed with gzip; unpack it first (gunzip)",
    b"BZh": "is packed with bzip2; unpack it first (bunzip2)",
    b"\xfd7zXZ": "is packed with xz; unpack it first (unxz)",
    b"\x28\xb5\x2f\xfd": "is packed with zstd; unpack it first (zstd -d)",
    b"PK\x03\x04": "is a zip archive or an Excel workbook; unpack it, or save the sheet as CSV",
    b"\xd0\xcf\x11\xe0": "is an Excel workbook or another document of Office; "
    "save the sheet as CSV",
    b"TDSm": "is a TDMS file of LabVIEW; export it as CSV or MATLAB",
}
# text that is not a table: a frictool document (by its first key) or an HTML page
DOCUMENT = re.compile(
    rb"^format: *['\"]?((?:bench|model|spec|design|controller|scenario|friction|observer|"
    rb"mechanism)/\d+)\b",
    re.MULTILINE,
)
PAGE = re.compile(rb"\s*<(?:!doctype|html)\b", re.IGNORECASE)


class FormatReader(Protocol):
    """Interface of the module of a format."""

    def sniff(self, head: bytes, path: Path) -> bool: ...

    def tables(self, path: Path, layout: Layout | None) -> tuple[RawTable, ...]: ...


def format_of(path: Path) -> Format:
    """Return the format of a raw file; raise LogError if it is unreadable or of no known format."""
    head = head_of(path)
    refuse_document(path, head)
    for one in FORMATS:
        if _reader(one).sniff(head, path):
            return one
    for signature, what in PACKED.items():
        if head.startswith(signature):
            raise LogError(path, what)
    raise LogError(
        path, f"is binary and no known format; allowed: {', '.join(one.name for one in FORMATS)}"
    )


def refuse_document(path: Path, head: bytes) -> None:
    """Raise LogError if the file is a frictool document or an HTML page.

    head: first bytes of the file.
    """
    if b"\0" not in head and (document := DOCUMENT.search(head)):
        raise LogError(path, f"is a document ({document[1].decode()}); a log file is expected")
    if PAGE.match(head):
        raise LogError(path, "is a page (HTML); a log file is expected")


def refuse_swapped(document: Path, log: Path) -> None:
    """Raise LogError if a log and a document were passed in the wrong order."""
    if not document.is_file() or not log.is_file():
        return
    given = DOCUMENT.search(head_of(log)) if log.stat().st_size else None
    if given and document.stat().st_size and not DOCUMENT.search(head_of(document)):
        raise LogError(
            log,
            f"is a document ({given[1].decode()}), and {document.name} is none; "
            "write the document first, then the log",
        )


def tables_of(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the tables of a raw file; raise LogError if it cannot be read or breaks its format."""
    return _reader(format_of(path)).tables(path, layout)


def open_tables(parts: Sequence[Path], layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the tables of a raw file or of the parts of one recording.

    Raises LogError as `tables_of` does.
    """
    return tables_of(parts[0], layout) if len(parts) == 1 else tables_of_parts(parts, layout)


def _reader(one: Format) -> FormatReader:
    return cast(FormatReader, importlib.import_module(one.module))
