"""Decoder of messages that another library decodes into objects (JSON, protobuf).

The numbers have the same paths as in ROS messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.logs.recordings.serialised_messages import LABELS, MOST_LISTED, Messages
from frictool.typing import Vector

MOST_NUMBERS = 20_000  # maximum number of numbers of one message
MOST_VALUES = 100_000  # maximum number of keys of one mapping


def numbers(
    message: object, path: str = "", labels: Sequence[str] = ()
) -> Iterator[tuple[str, float]]:
    """Yield path and value of each number in nested mappings and sequences.

    message: mapping, sequence or number.
    path: path of `message` itself.
    labels: names of sequence elements; used for each sequence of the same length as `labels`.

    The path of an element of a sequence contains the index of the element. An element with a label
    is yielded twice: first with the label in place of the index, then with the index. A sequence
    longer than MOST_LISTED is left out. Raises ValueError if a mapping has more than MOST_VALUES
    keys.
    """
    if isinstance(message, bool | int | float):
        try:
            yield path, float(message)
        except OverflowError:
            yield path, float("inf")
    elif isinstance(message, Mapping):
        if len(message) > MOST_VALUES:
            raise ValueError(f"has more than {MOST_VALUES} keys")
        labels = next((texts for key in LABELS if (texts := _labels(message.get(key)))), labels)
        for key, value in message.items():
            yield from numbers(value, f"{path}.{key}" if path else str(key), labels)
    elif isinstance(message, list | tuple) and len(message) <= MOST_LISTED:
        for index, value in enumerate(message):
            if len(labels) == len(message):
                yield from numbers(value, f"{path}[{labels[index]}]", labels)
            yield from numbers(value, f"{path}[{index}]", labels)


def _labels(texts: object) -> Sequence[str]:
    distinct = (
        isinstance(texts, list | tuple)
        and all(isinstance(text, str) for text in texts)
        and len(set(texts)) == len(texts)
    )
    return [str(text) for text in texts] if distinct and isinstance(texts, list | tuple) else ()


class ObjectDecoder:
    """Decoder of messages that a function converts to objects (implements Decoder).

    objects: function that converts the bytes of a message to nested mappings, sequences and
        numbers. The function may raise ValueError.
    """

    def __init__(self, objects: Callable[[bytes], object]) -> None:
        self._objects = objects

    def names(self, data: bytes) -> list[str]:
        """Return the paths of the numbers of one message (see Decoder)."""
        return list(self.numbers_of(data))

    def columns(
        self, messages: Messages, paths: tuple[str, ...]
    ) -> tuple[Vector, NDArray[np.bool_], dict[int, str]]:
        """Return the numbers at `paths` in the messages (see Decoder)."""
        count = messages.start.size
        values = np.full((len(paths), count), np.nan)
        present = np.zeros(values.shape, bool)
        failed: dict[int, str] = {}
        for index in range(count):
            try:
                numbers = self.numbers_of(messages.payload(index))
            except ValueError as error:
                failed[index] = str(error)
                continue
            values[:, index] = [numbers.get(path, np.nan) for path in paths]
            present[:, index] = [path in numbers for path in paths]
        return values, present, failed

    def numbers_of(self, data: bytes) -> dict[str, float]:
        """Return the numbers of one message, by their paths in the message.

        Raises ValueError if the message is damaged or has too many numbers.
        """
        decoded: dict[str, float] = {}
        try:
            for path, value in numbers(self._objects(data)):
                decoded[path] = value
                if len(decoded) > MOST_NUMBERS:
                    raise ValueError(f"has more than {MOST_NUMBERS} numbers")
        except RecursionError:
            raise ValueError("is nested too deeply") from None
        return decoded
