"""Block of serialised messages of one topic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from frictool.typing import IntVector

# arrays of texts that name the elements of the other arrays in the message
LABELS = ("name", "names", "joint_names", "interface_names")
MOST_LISTED = 1000  # maximum number of array elements that are listed one by one

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Messages:
    """Serialised messages of one topic; n is their number.

    log_time: recording times (n,) in ns.
    data: bytes that contain all payloads.
    start: index (n,) of each payload's first byte in `data`.
    length: length (n,) of each payload in bytes.
    """

    log_time: IntVector
    data: Bytes
    start: IntVector
    length: IntVector

    def payload(self, index: int) -> bytes:
        """Return the bytes of the message with this index."""
        start = int(self.start[index])
        return self.data[start : start + int(self.length[index])].tobytes()

    def at(self, which: NDArray[np.intp] | slice) -> Messages:
        """Return the messages with these indices."""
        return Messages(self.log_time[which], self.data, self.start[which], self.length[which])


def pack_messages(log_time: list[int], payloads: list[bytes]) -> Messages:
    """Join messages, which were read one by one, into a block."""
    length = np.fromiter(map(len, payloads), np.int64, len(payloads))
    return Messages(
        np.array(log_time, np.int64),
        np.frombuffer(b"".join(payloads), np.uint8),
        np.cumsum(length) - length,
        length,
    )


def gather(data: Bytes, start: IntVector, width: int) -> Bytes:
    """Return the matrix (n, width) with row i = data[start[i] : start[i] + width]."""
    if not start.size:
        return np.empty((0, width), np.uint8)
    windows = as_strided(data, (data.size - width + 1, width), (1, 1), writeable=False)
    gathered: Bytes = windows[start]
    return gathered
