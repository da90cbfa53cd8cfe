"""Data elements of a MATLAB file of version 5 to 7 ("level 5 MAT-File Format").

Some damaged files crash `scipy.io`. Therefore this module checks every length against the bytes
available before it uses the length, and verifies the checksum of a compressed variable.

A file consists of a head of 128 bytes and a sequence of elements. An element consists of type (4
bytes), size (4 bytes) and content, padded to a multiple of 8 bytes. A variable is an element of
type MATRIX, which may be inside an element of type COMPRESSED. The content of a MATRIX consists of
elements: flags, shape, name, real part, imaginary part. The content of a structure or cell array
consists of its fields or cells, which are MATRIX elements without a name.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from frictool.logs.arrays.array_table import ArrayColumn
from frictool.logs.arrays.byte_streams import ByteStream, FileBytes, InflatedBytes
from frictool.logs.arrays.mat_array import ADVICE, MatArray

HEAD_BYTES = 128
MATRIX, COMPRESSED = 14, 15
COMPLEX = 0x0800
SMALL_BYTES = 4096  # bytes, maximum size of flags, shape and name of a variable
LARGEST_TEXT = 1 << 20  # bytes, maximum size of a text or of all field names of a structure
DEEPEST = 12  # maximum depth of structures
MOST = 20_000  # maximum number of arrays
NUMBERS = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
CLASSES = (
    *("unknown", "cell", "struct", "object", "char", "sparse", "double", "single"),
    *(
        "int8",
        "uint8",
        "int16",
        "uint16",
        "int32",
        "uint32",
        "int64",
        "uint64",
        "function",
        "opaque",
    ),
)
NUMERIC = frozenset(CLASSES[6:16])


@dataclass(frozen=True)
class MatTag:
    """Head of a data element of the file.

    length: size of the content in bytes.
    inline: the content, if it is packed into the head; None if the content follows the head.
    fill: number of padding bytes after the content.
    """

    kind: int
    length: int
    inline: bytes | None
    fill: int


def arrays(path: Path, size: int) -> Iterator[MatArray]:
    """Yield the arrays of a file of `size` bytes in order.

    Fields are named `name.field`; cells are named `name{1}`. Raises ValueError where the file is
    truncated or damaged. A variable that is truncated inside its numbers is yielded before the
    error.
    """
    with path.open("rb") as file:
        order = ">" if file.read(HEAD_BYTES)[126:128] == b"MI" else "<"
        position = HEAD_BYTES
        count = 0
        while position < size:
            file.seek(position)
            head = file.read(8)
            if len(head) < 8:
                raise ValueError(f"is cut off at byte {position}")
            kind, length = struct.unpack(order + "II", head)
            start = position + 8
            if kind not in (MATRIX, COMPRESSED):
                raise ValueError(
                    f"found an element of type {kind} at byte {position}; allowed: variables"
                )
            for array in _variable(
                path,
                start if kind == COMPRESSED else position,
                min(length, size - start),
                kind == COMPRESSED,
                order,
            ):
                count += 1
                if count > MOST:
                    raise ValueError(f"has more than {MOST} arrays")
                yield array
            position = start + length
            if position > size:
                raise ValueError(
                    f"a variable at byte {start} declares {length} bytes, but {size - start} follow"
                )


def _variable(
    path: Path, start: int, length: int, compressed: bool, order: str
) -> Iterator[MatArray]:
    stream_type: type[ByteStream] = InflatedBytes if compressed else FileBytes
    open_stream = partial(stream_type, path, start, length if compressed else length + 8)
    with open_stream() as stream:
        walk = _MatVariableReader(stream, order, open_stream)
        tag = walk.tag()
        if tag.kind != MATRIX:
            raise ValueError(f"a variable is an element of type {tag.kind}; allowed: {MATRIX}")
        yield from walk.matrix("", tag.length, 0)


class _MatVariableReader:
    def __init__(self, stream: ByteStream, order: str, open_stream: partial[ByteStream]) -> None:
        self.stream = stream
        self.order = order
        self.open = open_stream

    def tag(self) -> MatTag:
        kind, length = struct.unpack(self.order + "II", self.exactly(8))
        if kind >> 16:  # content of up to 4 bytes is packed into the head
            small = kind >> 16
            if small > 4:
                raise ValueError(f"a packed element declares {small} bytes; allowed: at most 4")
            return MatTag(kind & 0xFFFF, small, struct.pack(self.order + "I", length)[:small], 0)
        return MatTag(kind, length, None, 0 if kind == COMPRESSED else -length % 8)

    def exactly(self, size: int) -> bytes:
        data = self.stream.read(size)
        if len(data) < size:
            raise ValueError(f"a variable {self.stream.damage}")
        return data

    def small(self, most: int = SMALL_BYTES) -> tuple[int, bytes]:
        tag = self.tag()
        if tag.inline is not None:
            return tag.kind, tag.inline
        if tag.length > most:
            raise ValueError(
                f"a part of a variable declares {tag.length} bytes; allowed: at most {most}"
            )
        return tag.kind, self.exactly(tag.length + tag.fill)[: tag.length]

    def matrix(self, path: str, length: int, depth: int) -> Iterator[MatArray]:
        """Yield the arrays in a MATRIX element whose head has been read.

        path: path of a field or cell. A variable has the path "", because its name is in the
            element.
        length: size of the element's content in bytes.
        """
        end = self.stream.position + length
        if length == 0:  # an empty array
            return
        _, flags = self.small()
        if len(flags) != 8:
            raise ValueError(f"a variable has a damaged head: its flags have {len(flags)} bytes")
        (bits,) = struct.unpack_from(self.order + "I", flags)
        kind = CLASSES[bits & 0xFF] if bits & 0xFF < len(CLASSES) else "unknown"
        if kind == "opaque":  # name, system (MCOS), class, and data that only MATLAB can interpret
            name, _, type_name = (self.small()[1].decode("latin-1") for _ in range(3))
            yield MatArray(path or name, (), f"{type_name}: {ADVICE}")
        else:
            shape = self.shape()
            name = self.small()[1].decode("latin-1")
            yield from self.content(path or name, shape, kind, bool(bits & COMPLEX), depth)
        if depth:  # a variable is the last element of its stream
            if self.stream.position > end:
                raise ValueError("an array is longer than its structure declares")
            self.stream.skip(end - self.stream.position)

    def shape(self) -> tuple[int, ...]:
        _, data = self.small()
        if len(data) % 4 or not 8 <= len(data) <= 128:
            raise ValueError(f"a variable has a damaged head: its shape has {len(data)} bytes")
        shape = tuple(int(n) for n in np.frombuffer(data, np.dtype(self.order + "i4")))
        if min(shape) < 0:
            raise ValueError(f"the shape of a variable is negative: {shape}")
        return shape

    def content(
        self, name: str, shape: tuple[int, ...], kind: str, is_complex: bool, depth: int
    ) -> Iterator[MatArray]:
        if kind in NUMERIC:
            yield self.numbers(name, shape, kind, is_complex)
        elif kind in ("struct", "cell"):
            if depth >= DEEPEST:
                raise ValueError(f"{name!r} is nested in more than {DEEPEST} structures")
            yield MatArray(name, shape, kind)
            yield from (
                self.fields(name, shape, depth)
                if kind == "struct"
                else self.cells(name, shape, depth)
            )
        elif kind == "char":
            code, data = self.small(LARGEST_TEXT)
            yield MatArray(name, shape, kind, text=data.decode(self.encoding(code), "replace"))
        else:
            yield MatArray(name, shape, kind)

    def encoding(self, code: int) -> str:
        encoding = TEXTS.get(code, "latin-1")
        return (
            encoding
            if "-8" in encoding or "latin" in encoding
            else encoding + ("-be" if self.order == ">" else "-le")
        )

    def numbers(self, name: str, shape: tuple[int, ...], kind: str, is_complex: bool) -> MatArray:
        if math.prod(shape) == 0:
            return MatArray(name, shape, kind)
        tag = self.tag()
        if tag.kind not in NUMBERS:
            raise ValueError(f"variable {name!r} contains type {tag.kind} instead of numbers")
        dtype = np.dtype(self.order + NUMBERS[tag.kind])
        if tag.length != dtype.itemsize * math.prod(shape):
            raise ValueError(
                f"variable {name!r} of {'x'.join(map(str, shape))} {kind} declares {tag.length} "
                "bytes of numbers"
            )
        # packed numbers are the last 4 bytes of the head
        offset = self.stream.position if tag.inline is None else self.stream.position - 4
        column = ArrayColumn(self.open, offset, dtype, math.prod(shape), dtype.itemsize)
        return MatArray(
            name, shape, f"{'complex ' * is_complex}{kind}", None if is_complex else column
        )

    def fields(self, name: str, shape: tuple[int, ...], depth: int) -> Iterator[MatArray]:
        _, data = self.small()
        width = struct.unpack(self.order + "i", data)[0] if len(data) == 4 else 0
        _, names = self.small(LARGEST_TEXT)
        if width <= 0 or len(names) % width:
            raise ValueError(f"the field names of structure {name!r} are damaged")
        fields = [
            names[at : at + width].partition(b"\0")[0].decode("latin-1")
            for at in range(0, len(names), width)
        ]
        for number in range(1, math.prod(shape) + 1 if fields else 1):
            owner = name if math.prod(shape) == 1 else f"{name}({number})"
            for one in fields:
                yield from self.inner(f"{owner}.{one}", depth)

    def cells(self, name: str, shape: tuple[int, ...], depth: int) -> Iterator[MatArray]:
        for number in range(1, math.prod(shape) + 1):
            yield from self.inner(f"{name}{{{number}}}", depth)

    def inner(self, path: str, depth: int) -> Iterator[MatArray]:
        tag = self.tag()
        if tag.kind != MATRIX:
            raise ValueError(f"{path!r} is an element of type {tag.kind}; allowed: {MATRIX}")
        start = self.stream.position
        yield from self.matrix(path, tag.length, depth + 1)
        self.stream.skip(start + tag.length - self.stream.position)
