"""Decoding of numbers from serialised messages: CDR of ROS 2, and the serialisation of ROS 1.

The offset of a number in a message depends only on the lengths of the strings and sequences before
it. Therefore the first message of each layout is parsed field by field. All messages of the same
size with the same lengths at the same offsets (`MessageLayout.guards`) have the same layout, and
their numbers are extracted together.

In CDR, the first 4 bytes give the byte order. Offsets are counted from the end of these bytes. The
offset of a number is a multiple of the number's size. Version 2 of CDR makes an exception: the
offset of a number of 8 bytes is a multiple of 4 bytes. The length of a text, including the closing
NUL, precedes the text. The length of a sequence precedes the sequence. A fixed array is stored
without its length.

In ROS 1, numbers are little-endian and not aligned, and texts have no closing NUL.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from frictool.logs.recordings.ros_message import NUMBERS, MessageField, MessageType
from frictool.logs.recordings.serialised_messages import LABELS, MOST_LISTED, Messages, gather
from frictool.typing import Vector

Bytes = NDArray[np.uint8]
MOST_STEPS = 200_000  # maximum number of fields and nested messages in one message
MOST_LAYOUTS = 64  # maximum number of new layouts per batch; then messages are read one by one
PADDING = 7  # maximum number of padding bytes after a message
KEPT_LAYOUTS = 16  # maximum number of layouts kept for the next batch
# second byte of CDR -> byte order; plain CDR of versions 1 and 2
ORDER = {0: ">", 1: "<", 6: ">", 7: "<"}
LARGEST_ALIGNMENT = {0: 8, 1: 8, 6: 4, 7: 4}


@dataclass(frozen=True)
class NumberField:
    """Number, or array of numbers, in a message.

    path: names of the enclosing fields and of the field, such as `pose.x`.
    offset: index of the field's first byte in the message.
    dtype: type of a number, such as `<f8`.
    count: length of the array; None for a single number.
    labels: names of the array's elements; empty if the elements have no names.
    """

    path: str
    offset: int
    dtype: str
    count: int | None
    labels: tuple[str, ...] = ()

    def paths(self) -> Iterator[str]:
        """Yield the path of each number in this field, such as `pose.x` or `position[0]`.

        An array element with a label has two paths: `position[label]` and `position[index]`. The
        paths with labels come first. An array longer than MOST_LISTED yields no path.
        """
        if self.count is None:
            yield self.path
        elif self.count <= MOST_LISTED:
            yield from (f"{self.path}[{label}]" for label in self.labels)
            yield from (f"{self.path}[{index}]" for index in range(self.count))

    def slot(self, path: str) -> tuple[int, str] | None:
        """Return (offset, dtype) of the field's number with this path; None for an unknown path."""
        if self.count is None:
            return (self.offset, self.dtype) if path == self.path else None
        if not path.startswith(self.path + "[") or not path.endswith("]"):
            return None
        key = path[len(self.path) + 1 : -1]
        index = (
            self.labels.index(key)
            if key in self.labels
            else int(key)
            if key.isascii() and key.isdigit() and len(key) < 10
            else -1
        )
        return (
            (self.offset + index * int(self.dtype[-1]), self.dtype)
            if 0 <= index < self.count
            else None
        )


@dataclass(frozen=True)
class MessageLayout:
    """Offsets of the numbers in a message of `size` bytes.

    leaves: all fields of numbers in the message.
    guards: offset and expected bytes of three kinds of items: byte order, lengths of strings and
        sequences, and texts that label array elements. The layout is valid only for messages with
        the same bytes at these offsets.
    """

    size: int
    leaves: tuple[NumberField, ...]
    guards: tuple[tuple[int, bytes], ...]

    def slots(self, paths: tuple[str, ...]) -> list[tuple[int, str] | None]:
        """Return (offset, dtype) for each path; None for a path that the layout does not have."""
        return [
            next((slot for leaf in self.leaves if (slot := leaf.slot(path))), None)
            for path in paths
        ]

    def fits(self, messages: Messages) -> NDArray[np.bool_]:
        """Return a mask (n,) that is True for each message with this layout."""
        fits: NDArray[np.bool_] = messages.length == self.size
        at = np.flatnonzero(fits)
        guards = np.concatenate(
            [np.arange(offset, offset + len(expected)) for offset, expected in self.guards]
            or [np.empty(0, np.intp)]
        )
        wanted = np.frombuffer(b"".join(expected for _, expected in self.guards), np.uint8)
        fits[at] = (messages.data[messages.start[at][:, None] + guards] == wanted).all(axis=1)
        return fits


class _CdrReader:
    def __init__(self, data: bytes, aligned: bool) -> None:
        self.data = data
        self.position = 0
        self.leaves: list[NumberField] = []
        self.guards: list[tuple[int, bytes]] = []
        self.steps = MOST_STEPS
        self.aligned = aligned
        self.order = "<"
        self.base = 0
        self.largest = 8
        if aligned:
            kind = data[1] if len(data) >= 4 and data[0] == 0 else -1
            if kind not in ORDER:
                raise ValueError(
                    f"begins with {data[:4].hex(' ') or 'nothing'}; allowed: plain CDR, "
                    "00 00 to 00 01 or 00 06 to 00 07"
                )
            self.order, self.largest = ORDER[kind], LARGEST_ALIGNMENT[kind]
            self.guards.append((0, data[:2]))
            self.position = self.base = 4

    def layout(self, message: MessageType) -> MessageLayout:
        self.message(message, "", ())
        if len(self.data) - self.position > PADDING:
            raise ValueError(
                f"has {len(self.data)} bytes, but its definition ends after {self.position} bytes"
            )
        return MessageLayout(len(self.data), tuple(self.leaves), tuple(self.guards))

    def take(self, size: int, alignment: int) -> int:
        if self.aligned:
            alignment = min(alignment, self.largest)
            self.position += -(self.position - self.base) % alignment
        start = self.position
        self.position += size
        if self.position > len(self.data):
            raise ValueError(
                f"is {len(self.data)} bytes long, but at least {self.position} are declared"
            )
        return start

    def length(self) -> int:
        """Read the length of a text or sequence.

        The bytes of the length are stored in `guards`, because all later offsets depend on the
        length.
        """
        start = self.take(4, 4)
        raw = self.data[start : start + 4]
        self.guards.append((start, raw))
        (value,) = struct.unpack(self.order + "I", raw)
        if value > len(self.data) - self.position:
            raise ValueError(
                f"declares {value} elements, but {len(self.data) - self.position} bytes remain"
            )
        return int(value)

    def text(self, guarded: bool) -> str:
        size = self.length()
        start = self.take(size, 1)
        raw = self.data[start : start + size]
        if guarded:
            self.guards.append((start, raw))
        return raw.rstrip(b"\0").decode("utf-8", "replace")

    def message(self, message: MessageType, prefix: str, labels: tuple[str, ...]) -> None:
        self.steps -= 1 + len(message.fields)
        if self.steps < 0:
            raise ValueError(f"has more than {MOST_STEPS} fields")
        if not message.fields and self.aligned:
            self.take(1, 1)  # CDR has no empty structures
        for part in message.fields:
            labels = self.field(part, f"{prefix}{part.name}", labels) or labels

    def field(self, part: MessageField, path: str, labels: tuple[str, ...]) -> tuple[str, ...]:
        count = (
            None
            if part.repeat == "once"
            else part.size
            if part.repeat == "fixed"
            else self.length()
        )
        if count is not None and count > len(self.data) - self.position:
            raise ValueError(
                f"has {count} elements in {path!r}, but {len(self.data) - self.position} bytes "
                "remain"
            )
        named = labels if len(labels) == count else ()
        if isinstance(part.kind, MessageType):
            for k in range(1 if count is None else count):
                name = path if count is None else f"{path}[{named[k] if named else k}]"
                self.message(part.kind, f"{name}.", labels)
        elif part.kind == "wstring":
            raise ValueError(f"has a wstring in {path!r}, of unknown encoding; allowed: string")
        elif part.kind == "string":
            texts = tuple(
                self.text(part.name in LABELS) for _ in range(1 if count is None else count)
            )
            return (
                texts
                if part.name in LABELS and count is not None and len(set(texts)) == count
                else ()
            )
        elif count != 0:
            dtype = NUMBERS[part.kind]
            size = int(dtype[1])
            start = self.take(size * (1 if count is None else count), size)
            self.leaves.append(NumberField(path, start, self.order + dtype, count, named))
        return ()


@dataclass
class MessageDecoder:
    """Decoder of serialised messages of one type into numbers (implements Decoder).

    message: type of the messages.
    aligned: True for CDR, which aligns numbers; False for ROS 1.
    """

    message: MessageType
    aligned: bool = True
    _layouts: list[MessageLayout] = field(default_factory=list)

    def names(self, data: bytes) -> list[str]:
        """Return the paths of all numbers in the message `data`.

        Raises ValueError if `data` is not a message of the decoder's type.
        """
        return [path for leaf in self._walked(data).leaves for path in leaf.paths()]

    def columns(
        self, messages: Messages, paths: tuple[str, ...]
    ) -> tuple[Vector, NDArray[np.bool_], dict[int, str]]:
        """Return the numbers at `paths` in the messages (see Decoder)."""
        values = np.full((len(paths), messages.start.size), np.nan)
        present = np.zeros(values.shape, bool)
        failed: dict[int, str] = {}
        left = np.arange(messages.start.size)
        for known in self._layouts:
            left = self._fill(known, messages, left, paths, values, present)
        tried = 0
        while left.size:
            first = int(left[0])
            tried = tried + 1
            try:
                layout = self._walked(messages.payload(first))
            except ValueError as error:
                failed[first] = str(error)
                left = left[1:]
                continue
            self._layouts = [layout, *self._layouts[: KEPT_LAYOUTS - 1]]
            among = left if tried < MOST_LAYOUTS else left[:1]
            left = np.append(
                self._fill(layout, messages, among, paths, values, present), left[among.size :]
            )
        return values, present, failed

    def _walked(self, data: bytes) -> MessageLayout:
        return _CdrReader(data, self.aligned).layout(self.message)

    @staticmethod
    def _fill(
        layout: MessageLayout,
        messages: Messages,
        left: NDArray[np.intp],
        paths: tuple[str, ...],
        values: Vector,
        present: NDArray[np.bool_],
    ) -> NDArray[np.intp]:
        if not left.size:
            return left
        fits = layout.fits(messages.at(left))
        rows = left[fits]
        for path, slot in enumerate(layout.slots(paths)):
            if slot is not None:
                offset, dtype = slot
                values[path, rows] = gather(
                    messages.data, messages.start[rows] + offset, int(dtype[-1])
                ).view(dtype)[:, 0]
                present[path, rows] = True
        return left[~fits]
