"""Limit of the unpacked size of a file; a file above the limit is damaged or an attack."""

from __future__ import annotations

MOST_TIMES = 1000  # largest ratio of unpacked size to file size
LARGE = 4 << 30  # bytes, unpacked size above which the ratio is at most MOST_TIMES_LARGE
MOST_TIMES_LARGE = 20
SMALL = 64_000_000  # bytes, unpacked size allowed for any file


def allowed_bytes(size: int) -> int:
    """Return the largest unpacked size, in bytes, allowed for a file of `size` bytes."""
    return max(SMALL, min(MOST_TIMES * size, max(LARGE, MOST_TIMES_LARGE * size)))


class UnpackedBudget:
    """Number of bytes that may still be unpacked from a file of `size` bytes."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._allowed = allowed_bytes(size)
        self._left = self._allowed

    def take(self, count: int) -> str | None:
        """Subtract `count` from the number of bytes that may still be unpacked, and return None.

        If `count` exceeds this number, return a message and leave the number unchanged.
        """
        if count <= self._left:
            self._left -= count
            return None
        return f"its {self._size} bytes declare more than {self._allowed} unpacked bytes"


def refusal(size: int, rows: int, columns: int) -> str | None:
    """Return why a file of `size` bytes cannot contain `rows` x `columns` numbers, or None."""
    if 8 * rows * columns <= allowed_bytes(size):
        return None
    return (
        f"declares {rows} rows in {size} bytes; allowed: "
        f"{allowed_bytes(size) // max(8 * columns, 1)} rows in a file of this size"
    )
