"""Reading of the arrays in a MATLAB file of version 4.

An array consists of a head of 20 bytes, a name, and the numbers, which are stored column by column.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictool.logs.arrays.array_table import ArrayColumn
from frictool.logs.arrays.byte_streams import FileBytes
from frictool.logs.arrays.mat_array import MatArray

HEAD = 20  # bytes
LONGEST_NAME = 64  # bytes
ORDERS = {0: "<", 1: ">"}  # code of the byte order -> its sign in `struct`
NUMBERS = ("f8", "f4", "i4", "i2", "u2", "u1")
CLASSES = ("double", "single", "int32", "int16", "uint16", "uint8")
KINDS = ("", "char", "sparse")
_NAME = re.compile(rb"[A-Za-z][A-Za-z0-9_]*\0+")


class Mat4Header(NamedTuple):
    """Head of an array in a MATLAB file of version 4.

    number: index of the number type in the list NUMBERS.
    kind: index of the kind of array in the list KINDS.
    shape: numbers of rows and columns.
    is_complex: True if an imaginary part follows the real part.
    name_bytes: length of the array's name in bytes.
    """

    order: str
    number: int
    kind: int
    shape: tuple[int, int]
    is_complex: bool
    name_bytes: int

    @property
    def bytes(self) -> int:
        """Return the size of the array's numbers in bytes."""
        return (
            np.dtype(NUMBERS[self.number]).itemsize
            * self.shape[0]
            * self.shape[1]
            * (2 if self.is_complex else 1)
        )


def looks_like(head: bytes) -> bool:
    """Return True if a file with the first bytes `head` may be a MATLAB file of version 4.

    This version has no signature. Therefore the file must begin with a valid head and a valid name.
    """
    element = _head(head[:HEAD])
    return (
        element is not None and _NAME.fullmatch(head[HEAD : HEAD + element.name_bytes]) is not None
    )


def arrays(path: Path, size: int) -> Iterator[MatArray]:
    """Yield the arrays of a file of `size` bytes.

    Raises ValueError if the file is truncated or damaged. A truncated array is yielded before the
    error.
    """
    position = 0
    with path.open("rb") as file:
        while position < size:
            file.seek(position)
            head = _head(file.read(HEAD))
            if head is None:
                raise ValueError(f"no array begins at byte {position}")
            name = file.read(head.name_bytes)
            if not _NAME.fullmatch(name):
                raise ValueError(f"an array at byte {position} has no name")
            start = position + HEAD + head.name_bytes
            yield _array(path, head, name.rstrip(b"\0").decode("ascii"), start, size)
            position = start + head.bytes
            if position > size:
                raise ValueError(
                    f"an array at byte {start} declares {head.bytes} bytes, but {size - start} "
                    "follow"
                )


def _array(path: Path, head: Mat4Header, name: str, start: int, size: int) -> MatArray:
    if head.kind or head.is_complex:
        return MatArray(name, head.shape, KINDS[head.kind] or f"complex {CLASSES[head.number]}")
    dtype = np.dtype(head.order + NUMBERS[head.number])
    column = ArrayColumn(
        partial(FileBytes, path, start, size - start),
        0,
        dtype,
        head.shape[0] * head.shape[1],
        dtype.itemsize,
    )
    return MatArray(name, head.shape, CLASSES[head.number], column)


def _head(data: bytes) -> Mat4Header | None:
    if len(data) < HEAD:
        return None
    for code, order in ORDERS.items():
        kind, rows, columns, imaginary, name_bytes = struct.unpack(order + "5i", data)
        order_code, rest = divmod(kind, 1000)
        hundreds, rest = divmod(rest, 100)
        number, kind = divmod(rest, 10)
        fits = order_code == code and hundreds == 0 and number < len(NUMBERS) and kind < len(KINDS)
        if (
            fits
            and rows >= 0
            and columns >= 0
            and imaginary in (0, 1)
            and 2 <= name_bytes <= LONGEST_NAME
        ):
            return Mat4Header(order, number, kind, (rows, columns), bool(imaginary), name_bytes)
    return None
