"""Limit of a file's unpacked size, as a protection against decompression bombs."""

from __future__ import annotations

MOST_TIMES = 1000  # largest ratio of unpacked size to file size, up to LARGE unpacked bytes
LARGE = 4 << 30  # bytes; the ratio of a larger unpacked size is at most MOST_TIMES_LARGE
MOST_TIMES_LARGE = 20
SMALL = 64_000_000  # bytes; this unpacked size is allowed for a file of any size


def allowed_bytes(size: int) -> int:
    """Return the largest unpacked size [bytes] allowed for a file of `size` bytes."""
    return max(SMALL, min(MOST_TIMES * size, max(LARGE, MOST_TIMES_LARGE * size)))


class UnpackedBudget:
    """Budget of unpacked bytes for a file of `size` bytes."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._allowed = allowed_bytes(size)
        self._left = self._allowed

    def take(self, count: int) -> str | None:
        """Subtract `count` bytes from the remaining budget and return None.

        If `count` exceeds the remaining budget, return a message and leave the budget unchanged.
        """
        if count <= self._left:
            self._left -= count
            return None
        return (
            f"unpacks to more than {self._allowed} bytes, the limit for {self._size} packed bytes"
        )


def refusal(size: int, rows: int, columns: int) -> str | None:
    """Return a message if `rows` x `columns` numbers exceed the limit for the file; else None.

    size: size of the file in bytes.
    """
    if 8 * rows * columns <= allowed_bytes(size):
        return None
    return (
        f"declares {rows} rows in {size} bytes; allowed: at most "
        f"{allowed_bytes(size) // max(8 * columns, 1)} rows in a file of this size"
    )
