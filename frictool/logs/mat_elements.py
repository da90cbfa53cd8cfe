"""The data elements of a MATLAB file up to version 7 ("level 5 MAT-File Format"): variables by name, shape and class, numbers on demand.

`scipy.io` reads these files too, but ends the process with a segmentation fault on some damaged ones. Here every length is checked
against what there is before it is believed, and the checksum of a compressed variable is.

A file is a head of 128 bytes, then elements: type (4), bytes (4), content. A variable is an element of type MATRIX, alone or inside one
of type COMPRESSED; its content is again elements: flags, shape, name, real part, imaginary part.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from frictool.logs.log import Vector

HEAD_BYTES = 128
MATRIX, COMPRESSED = 14, 15
COMPLEX = 0x0800
PEEK_BYTES = 4096  # flags, shape and name (at most 63 characters) lie within
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
CLASSES = (
    *("unknown", "cell", "struct", "object", "char", "sparse", "double", "single"),
    *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "function", "opaque"),
)
NUMERIC = frozenset(CLASSES[6:16])


@dataclass(frozen=True)
class Variable:
    """A variable of the file; `content` is its element, compressed or not."""

    name: str
    shape: tuple[int, ...]
    kind: str
    is_complex: bool
    order: str
    content: bytes
    compressed: bool

    @property
    def is_vector(self) -> bool:
        """Whether it is a column or a row of real numbers, at least two."""
        return self.kind in NUMERIC and not self.is_complex and len(self.shape) == 2 and min(self.shape) == 1 < max(self.shape)

    def __str__(self) -> str:
        return f"{'x'.join(map(str, self.shape))} {'complex ' * self.is_complex}{self.kind}"

    def numbers(self) -> Vector:
        """The real part (n,), in column order. Raises ValueError where the variable is damaged."""
        data = _inflate_all(self.content, self.order) if self.compressed else self.content
        position = 0
        for _ in range(3):
            *_, position = _element(data, position, self.order)
        kind, payload, _ = _element(data, position, self.order)
        if kind not in NUMBERS:
            raise ValueError(f"variable {self.name!r} holds no numbers but type {kind}")
        dtype = np.dtype(self.order + NUMBERS[kind])
        if len(payload) != dtype.itemsize * math.prod(self.shape):
            raise ValueError(f"variable {self.name!r} of {self} holds {len(payload)} bytes")
        return np.frombuffer(payload, dtype).astype(np.float64)


def variables(stream: BinaryIO, size: int) -> Iterator[Variable]:
    """The variables of an open file of `size` bytes, in its order. Raises ValueError where it is cut off or damaged."""
    head = stream.read(HEAD_BYTES)
    order = ">" if head[126:128] == b"MI" else "<"
    position = HEAD_BYTES
    while position < size:
        tag = stream.read(8)
        if len(tag) < 8:
            raise ValueError(f"is cut off at byte {position}")
        kind, length = struct.unpack(order + "II", tag)
        position += 8 + length
        if position > size:
            raise ValueError(f"a variable at byte {position - length} announces {length} bytes, {size - position + length} remain")
        content = stream.read(length)
        if kind not in (MATRIX, COMPRESSED):
            raise ValueError(f"an element of type {kind} stands before byte {position}; allowed: variables")
        yield _variable(content, order, kind == COMPRESSED)


def _variable(content: bytes, order: str, compressed: bool) -> Variable:
    start = _inflate_start(content)[8:] if compressed else content
    _, flags, position = _element(start, 0, order)
    _, shape, position = _element(start, position, order)
    _, name, position = _element(start, position, order)
    if len(flags) != 8 or len(shape) % 4 or not 8 <= len(shape) <= 128:
        raise ValueError(f"the head of a variable is damaged ({len(flags)} bytes of flags, {len(shape)} of shape)")
    (bits,) = struct.unpack_from(order + "I", flags)
    lengths = tuple(int(n) for n in np.frombuffer(shape, np.dtype(order + "i4")))
    kind = CLASSES[bits & 0xFF] if bits & 0xFF < len(CLASSES) else "unknown"
    return Variable(name.decode("latin-1"), lengths, kind, bool(bits & COMPLEX), order, content, compressed)


def _element(data: bytes, position: int, order: str) -> tuple[int, bytes, int]:
    """Type and content of the element at `position`, and where the next one starts."""
    if position + 8 > len(data):
        raise ValueError("a variable is cut off")
    kind, length = struct.unpack_from(order + "II", data, position)
    if kind >> 16:  # up to 4 bytes are packed into the tag itself
        kind, length, start, after = kind & 0xFFFF, kind >> 16, position + 4, position + 8
    else:
        start, after = position + 8, position + 8 + length + -length % 8
    if start + length > len(data) or (start == position + 4 and length > 4):
        raise ValueError(f"a part of a variable announces {length} bytes, {len(data) - start} are there")
    return kind, data[start : start + length], after


def _inflate_start(content: bytes) -> bytes:
    try:
        return zlib.decompressobj().decompress(content, PEEK_BYTES)
    except zlib.error as error:
        raise ValueError(f"a compressed variable is damaged ({error})") from None


def _inflate_all(content: bytes, order: str) -> bytes:
    """The content of a compressed MATRIX, not longer than it says; its checksum is checked."""
    inflater = zlib.decompressobj()
    try:
        tag = inflater.decompress(content, 8)
        kind, length = struct.unpack(order + "II", tag) if len(tag) == 8 else (0, 0)
        data = inflater.decompress(inflater.unconsumed_tail, length) if length else b""
        rest = inflater.decompress(inflater.unconsumed_tail, 1)  # nothing, but the checksum is read
    except zlib.error as error:
        raise ValueError(f"a compressed variable is damaged ({error})") from None
    if kind != MATRIX or len(data) != length or rest or not inflater.eof:
        raise ValueError("a compressed variable is damaged or cut off")
    return data
