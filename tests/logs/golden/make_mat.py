"""Writes the golden MATLAB files byte by byte, as the description of the formats says, without a
library.

python tests/logs/golden/make_mat.py
"""

from __future__ import annotations

import struct
from pathlib import Path

TIME = (0.0, 0.5, 1.0)
COUNTS = (-1, 2, 300)


def v4(order: str, code: int) -> bytes:
    """Head (1000 order + 10 type + kind, rows, columns, imaginary, length of the name), name,
    numbers."""
    data = b""
    for name, number, letter, values in (("t", 0, "d", TIME), ("counts", 3, "h", COUNTS)):
        head = struct.pack(
            order + "5i", 1000 * code + 10 * number, len(values), 1, 0, len(name) + 1
        )
        data += head + name.encode() + b"\0" + struct.pack(f"{order}{len(values)}{letter}", *values)
    return data


def element(kind: int, content: bytes) -> bytes:
    if len(content) <= 4:
        return struct.pack("<HH", kind, len(content)) + content.ljust(4, b"\0")
    return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)


def v5() -> bytes:
    """Elements: flags (class double 6, int16 10), shape, name, numbers (double 9, int16 3)."""
    data = b"MATLAB 5.0 MAT-file, written by hand".ljust(124) + b"\x00\x01IM"
    for name, kind, number, letter, values in (
        ("t", 6, 9, "d", TIME),
        ("counts", 10, 3, "h", COUNTS),
    ):
        flags, shape = (
            element(6, struct.pack("<II", kind, 0)),
            element(5, struct.pack("<ii", len(values), 1)),
        )
        numbers = element(number, struct.pack(f"<{len(values)}{letter}", *values))
        data += element(14, flags + shape + element(1, name.encode()) + numbers)
    return data


if __name__ == "__main__":
    folder = Path(__file__).parent
    (folder / "v4.mat").write_bytes(v4("<", 0))
    (folder / "v4_big_endian.mat").write_bytes(v4(">", 1))
    (folder / "v5.mat").write_bytes(v5())
