"""Writer of streams as a MATLAB file of version 5, which MATLAB writes with the option -v6.

The variables are the vector `time`, a vector for each signal (such as `position`) and the structure
`units`. If there are several streams, the structure `streams` contains a structure for each stream,
for example `streams.axis.position` and `streams.axis.units.position`. The file has no date, so that
the same log gives the same bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import BinaryIO

from frictool.documents.provenance import readable
from frictool.errors import OutputError
from frictool.logs.arrays.mat_elements import CLASSES, HEAD_BYTES, MATRIX
from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import OutgoingStream, flat_names
from frictool.typing import Vector

INT8, INT32, UINT16, UINT32, DOUBLE = 1, 5, 4, 6, 9  # element types
LONGEST = 2**31 - 1  # bytes, largest variable that MATLAB reads
Value = Vector | str | Mapping[str, "Value"]


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Write all streams; write the metadata records `notes` as structures of texts.

    Raises OutputError if a variable is too long for MATLAB.
    """
    values: dict[str, Mapping[str, Value]] = {}
    for stream, key in zip(streams, flat_names(streams), strict=True):
        units: Mapping[str, Value] = dict(zip(stream.names, stream.units, strict=True))
        values[key] = {**dict(zip(stream.names, stream.whole(), strict=True)), "units": units}
    top: Mapping[str, Value] = (
        next(iter(values.values())) if len(values) == 1 else {"streams": values}
    )
    for piece in pieces({**top, "notes": notes}):
        target.write(piece)


def pieces(values: Mapping[str, Value]) -> Iterator[bytes]:
    """Yield the bytes of a MATLAB file with the variables `values`, in parts.

    values: texts, structures, vectors (n,) or matrices (n, m), by name. A vector becomes a column.

    Raises OutputError if a variable is too long for MATLAB.
    """
    yield b"MATLAB 5.0 MAT-file, written by frictool".ljust(HEAD_BYTES - 4) + b"\x00\x01IM"
    for name, value in values.items():
        yield _matrix(name, value)


def _matrix(name: str, value: Value) -> bytes:
    if isinstance(value, Mapping):
        fields = {_field(key): inner for key, inner in value.items()}
        width = max(map(len, fields), default=0) + 1
        names = b"".join(key.encode("ascii").ljust(width, b"\0") for key in fields)
        content = (
            _element(INT32, struct.pack("<i", width))
            + _element(INT8, names)
            + b"".join(_matrix("", inner) for inner in fields.values())
        )
        return _array(name, "struct", (1, 1), content)
    if isinstance(value, str):
        text = readable(value).encode("utf-16-le")
        return _array(name, "char", (1, len(text) // 2), _element(UINT16, text))
    shape = (value.shape[0], value.shape[1]) if value.ndim == 2 else (value.size, 1)
    return _array(name, "double", shape, _element(DOUBLE, value.astype("<f8").tobytes(order="F")))


def _array(name: str, kind: str, shape: tuple[int, int], content: bytes) -> bytes:
    flags = _element(UINT32, struct.pack("<II", CLASSES.index(kind), 0))
    head = (
        flags + _element(INT32, struct.pack("<ii", *shape)) + _element(INT8, name.encode("ascii"))
    )
    if len(head) + len(content) > LONGEST:
        raise OutputError(
            f"variable {name or 'of a structure'} has {len(content)} bytes; allowed in MATLAB: at "
            f"most {LONGEST}; shorten the log by `frictool ingest --from --to`"
        )
    return _element(MATRIX, head + content)


def _element(kind: int, content: bytes) -> bytes:
    if 0 < len(content) <= 4:
        return struct.pack("<HH", kind, len(content)) + content.ljust(4, b"\0")
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def _field(key: str) -> str:
    name = "".join(c if c.isascii() and c.isalnum() else "_" for c in key).strip("_")
    return (name if name[:1].isalpha() else f"n{name}")[:63]
