"""How much the content of a file may grow when it is unpacked: what grows further is no log but an attack, or damaged."""

from __future__ import annotations

MOST_TIMES = 1000  # the bytes of the file
LARGE = 4 << 30  # bytes: what is unpacked to more may grow MOST_TIMES_LARGE at most
MOST_TIMES_LARGE = 20
SMALL = 64_000_000  # bytes that any file may hold


def allowed_bytes(size: int) -> int:
    """Return how many bytes a file of `size` bytes may hold when it is unpacked."""
    return max(SMALL, min(MOST_TIMES * size, max(LARGE, MOST_TIMES_LARGE * size)))


class Budget:
    """Bytes that a file of `size` bytes may still hold."""

    def __init__(self, size: int) -> None:
        self._size, self._allowed = size, allowed_bytes(size)
        self._left = self._allowed

    def take(self, count: int) -> str | None:
        """Take `count` unpacked bytes; return None, or take nothing and return why they may not be unpacked."""
        if count <= self._left:
            self._left -= count
            return None
        return f"its {self._size} bytes announce more than {self._allowed} unpacked"


def refusal(size: int, rows: int, columns: int) -> str | None:
    """Return why a file of `size` bytes may not hold so many rows of so many numbers of 8 bytes, or None."""
    if 8 * rows * columns <= allowed_bytes(size):
        return None
    return f"announces {rows} rows in {size} bytes; allowed: {allowed_bytes(size) // max(8 * columns, 1)} rows in a file of this size"
