"""Vector that grows when values are appended, for reading a file into one array."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

MARGIN = 1.05  # factor on the estimated final length: compression varies along the file


class GrowingVector:
    """Vector to which values are appended.

    Memory is reserved for the estimated final length. The estimate is at most `most` elements.
    """

    def __init__(self, dtype: DTypeLike, most: int) -> None:
        self._data = np.empty(0, dtype)
        self._size = 0
        self._most = most

    def append(self, values: NDArray[Any], share: float) -> None:
        """Append values (n,).

        share: fraction of the file that has been read, including these values.
        """
        end = self._size + values.size
        if end > self._data.size:
            seems = int(min(end / share * MARGIN, self._most))
            grown = np.empty(max(seems, 2 * end if self._size else end), self._data.dtype)
            grown[: self._size] = self._data[: self._size]
            self._data = grown
        self._data[self._size : end] = values
        self._size = end

    def whole(self) -> NDArray[Any]:
        """Return all values appended so far (n,), without a copy."""
        return self._data[: self._size]
