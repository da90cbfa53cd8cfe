"""A vector that grows at its end, so that what is read stands in one place at once and is not held
twice."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

MARGIN = 1.05  # of the length that a file seems to need: compression varies along it


class GrowingVector:
    """Room is taken for the length that the file seems to need, and no more than `most` on that
    ground."""

    def __init__(self, dtype: DTypeLike, most: int) -> None:
        self._data, self._size, self._most = np.empty(0, dtype), 0, most

    def append(self, values: NDArray[Any], share: float) -> None:
        """values (n,); share: of the file, read so far with them."""
        end = self._size + values.size
        if end > self._data.size:
            seems = int(min(end / share * MARGIN, self._most))
            grown = np.empty(max(seems, 2 * end if self._size else end), self._data.dtype)
            grown[: self._size] = self._data[: self._size]
            self._data = grown
        self._data[self._size : end] = values
        self._size = end

    def whole(self) -> NDArray[Any]:
        return self._data[: self._size]
