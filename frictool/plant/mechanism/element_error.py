"""Error of an element of a mechanism; the command that knows the file adds name and line."""

from __future__ import annotations


class ElementError(ValueError):
    """An element that cannot be part of the mechanism.

    key: path of the element in the document, for example `links.rack.radius`.
    """

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)
