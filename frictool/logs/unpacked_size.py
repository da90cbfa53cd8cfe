"""Bound of the unpacked size of a file: a file that grows further is damaged or an attack."""

from __future__ import annotations

MOST_TIMES = 1000  # the bytes of the file
LARGE = 4 << 30  # bytes: content that unpacks to more may grow by MOST_TIMES_LARGE at most
MOST_TIMES_LARGE = 20
SMALL = 64_000_000  # bytes to which any file may unpack


def allowed_bytes(size: int) -> int:
    """Return the largest unpacked size, in bytes, allowed for a file of `size` bytes."""
    return max(SMALL, min(MOST_TIMES * size, max(LARGE, MOST_TIMES_LARGE * size)))


class UnpackedBudget:
    """Bytes that may still be unpacked from a file of `size` bytes."""

    def __init__(self, size: int) -> None:
        self._size, self._allowed = size, allowed_bytes(size)
        self._left = self._allowed

    def take(self, count: int) -> str | None:
        """Subtract `count` unpacked bytes from the budget and return None; if they exceed it, leave
        it and return the reason."""
        if count <= self._left:
            self._left -= count
            return None
        return f"its {self._size} bytes announce more than {self._allowed} unpacked"


def refusal(size: int, rows: int, columns: int) -> str | None:
    """Return why a file of `size` bytes may not hold so many rows of so many numbers of 8 bytes, or
    None."""
    if 8 * rows * columns <= allowed_bytes(size):
        return None
    return f"announces {rows} rows in {size} bytes; allowed: {allowed_bytes(size) // max(8 * columns, 1)} rows in a file of this size"
