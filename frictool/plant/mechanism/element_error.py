"""What is wrong with an element of a mechanism; the command that knows the file adds it and the
line."""

from __future__ import annotations


class ElementError(ValueError):
    """An element that cannot be part of the mechanism. key: where it stands in the document,
    `links.rack.radius`."""

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)
