"""Registry of the formats of log files, and detection of the format of a file from its content.

A new format needs its modules, a row in FORMATS, a test and a row in docs/log_formats.md. A reader
module has the functions of FormatReader; a writer module has the function of FormatWriter
(conversion.py). Both are imported only when a file of the format is read or written.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol, cast

from frictool.errors import LogError
from frictool.logs.open_file import head_of
from frictool.logs.optional_libraries import library

if TYPE_CHECKING:
    from frictool.documents.bench import Layout
    from frictool.logs.raw_table import RawTable


class Format(NamedTuple):
    """File format of logs.

    name: short name, used in `convert --to`.
    title: name used in messages.
    suffixes: usual file suffixes. A written file gets the first suffix.
    reader: module that reads the format.
    writer: module that writes the format; "" if frictool does not write it.
    written: name of the format in the help of commands that write it.
    several: True if a written file can contain several streams.
    library: (module, extra): the Python module that the format needs, and the extra of frictool
        that installs this module; None if the format needs no library.
    other_suffixes: less usual suffixes of files that are read as logs.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    reader: str
    writer: str = ""
    written: str = ""
    several: bool = True
    library: tuple[str, str] | None = None
    other_suffixes: tuple[str, ...] = ()


# in the order of detection; the text format, the last one, accepts any file without a NUL character
FORMATS = (
    Format(
        "recording",
        "MCAP and ROS bags",
        (".mcap", ".bag", ".db3"),
        "frictool.logs.recordings.recording_format",
    ),
    Format(
        "mat",
        "MATLAB",
        (".mat",),
        "frictool.logs.arrays.mat_format",
        "frictool.logs.arrays.mat_writer",
        "MATLAB (version 5)",
    ),
    Format(
        "mat73",
        "MATLAB 7.3",
        (".mat",),
        "frictool.logs.arrays.mat73_format",
        library=("h5py", "mat73"),
    ),
    Format(
        "mdf",
        "MDF",
        (".mf4", ".mdf"),
        "frictool.logs.arrays.mdf_format",
        "frictool.logs.arrays.mdf_writer",
        "MDF 4.10",
        library=("asammdf", "mdf"),
        other_suffixes=(".dat",),
    ),
    Format(
        "parquet",
        "Parquet",
        (".parquet", ".pq"),
        "frictool.logs.arrays.parquet_format",
        "frictool.logs.arrays.parquet_writer",
        "Parquet",
        several=False,
        library=("pyarrow.parquet", "parquet"),
    ),
    Format(
        "npz",
        "NumPy",
        (".npz",),
        "frictool.logs.arrays.npz_format",
        "frictool.logs.arrays.npz_writer",
        "NumPy (.npz)",
    ),
    Format(
        "tdms",
        "TDMS",
        (".tdms",),
        "frictool.logs.arrays.tdms_format",
        library=("nptdms", "tdms"),
    ),
    Format(
        "ulog",
        "ULog",
        (".ulg",),
        "frictool.logs.arrays.ulog_format",
        library=("pyulog", "ulog"),
    ),
    Format(
        "can",
        "CAN (BLF, ASC, candump, PCAN-Trace)",
        (".blf", ".asc"),
        "frictool.logs.arrays.can_format",
        library=("can", "can"),
        other_suffixes=(".candump", ".trc"),
    ),
    Format(
        "jsonl",
        "JSON lines",
        (".jsonl", ".ndjson"),
        "frictool.logs.text.json_lines_format",
    ),
    Format(
        "csv",
        "text with columns (CSV)",
        (".csv",),
        "frictool.logs.text.csv_format",
        "frictool.logs.text.csv_writer",
        "CSV",
        several=False,
        other_suffixes=(".tsv", ".txt", ".lvm"),
    ),
)
WRITTEN = {one.name: one for one in sorted(FORMATS) if one.writer}
# suffixes of the files that are read as logs
SUFFIXES = tuple(
    dict.fromkeys(end for one in FORMATS for end in (*one.suffixes, *one.other_suffixes))
)

# first bytes -> message, for files that are not logs but may contain a log
PACKED = {
    b"\x1f\x8b": "is packed with gzip; unpack it first (gunzip)",
    b"BZh": "is packed with bzip2; unpack it first (bunzip2)",
    b"\xfd7zXZ": "is packed with xz; unpack it first (unxz)",
    b"\x28\xb5\x2f\xfd": "is packed with zstd; unpack it first (zstd -d)",
    b"PK\x03\x04": "is a zip archive or an Excel workbook; unpack it, or save the sheet as CSV",
    b"\xd0\xcf\x11\xe0": "is an Excel workbook or another document of Office; "
    "save the sheet as CSV",
}
PAGE = re.compile(rb"\s*<(?:!doctype|html)\b", re.IGNORECASE)


class FormatReader(Protocol):
    """Interface of a module that reads log files in one format."""

    def sniff(self, head: bytes, path: Path) -> bool:
        """Return True if the file `path`, whose first bytes are `head`, has this format."""

    def tables(self, path: Path, layout: Layout | None) -> tuple[RawTable, ...]:
        """Return the tables of a file; `layout` is the layout in bench.yaml, or None."""


def format_of(path: Path) -> Format:
    """Return the format of a raw file.

    Raises LogError if the file cannot be read or its format is unknown.
    """
    head = head_of(path)
    refuse_document(path, head)
    for one in FORMATS:
        if _reader(one).sniff(head, path):
            return one
    for signature, what in PACKED.items():
        if head.startswith(signature):
            raise LogError(path, what)
    raise LogError(
        path, f"is binary and of unknown format; allowed: {', '.join(one.title for one in FORMATS)}"
    )


@cache
def _document_key() -> re.Pattern[bytes]:
    from frictool.documents.registry import DOCUMENTS

    names = "|".join(DOCUMENTS).encode()
    return re.compile(rb"^format: *['\"]?((?:" + names + rb")/\d+)\b", re.MULTILINE)


def refuse_document(path: Path, head: bytes) -> None:
    """Raise LogError if the file is a frictool document or an HTML page.

    head: first bytes of the file.
    """
    if b"\0" not in head and (document := _document_key().search(head)):
        raise LogError(path, f"is a document ({document[1].decode()}); a log file is expected")
    if PAGE.match(head):
        raise LogError(path, "is an HTML page; a log file is expected")


def refuse_swapped(document: Path, log: Path) -> None:
    """Raise LogError if the document and the log were passed in the wrong order."""
    if not document.is_file() or not log.is_file():
        return
    match = _document_key().search(head_of(log)) if log.stat().st_size else None
    if match and document.stat().st_size and not _document_key().search(head_of(document)):
        raise LogError(
            log,
            f"is a document ({match[1].decode()}), but {document.name} is not; write the document "
            "first, then the log",
        )


def tables_of(path: Path, layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the tables of a raw file.

    layout: layout of the file declared in the bench; None to detect the layout.

    Raises LogError if the file is unreadable or damaged.
    """
    log_format = format_of(path)
    require(log_format, path)
    return _reader(log_format).tables(path, layout)


def open_tables(parts: Sequence[Path], layout: Layout | None = None) -> tuple[RawTable, ...]:
    """Return the tables of one raw file, or of one recording that is split into several files.

    Raises LogError if a file is unreadable or damaged.
    """
    if len(parts) == 1:
        return tables_of(parts[0], layout)
    from frictool.logs.recordings.recording_format import tables_of_parts

    return tables_of_parts(parts, layout)


def format_for(path: Path) -> Format | None:
    """Return the written format that has the suffix of `path`; None for an unknown suffix."""
    return next((one for one in WRITTEN.values() if path.suffix.lower() in one.suffixes), None)


def require(form: Format | None, path: Path) -> None:
    """Raise LogError about the file `path` if the library of its format is not installed."""
    if form is not None and form.library is not None:
        library(path, *form.library)


def _reader(one: Format) -> FormatReader:
    return cast(FormatReader, importlib.import_module(one.reader))
