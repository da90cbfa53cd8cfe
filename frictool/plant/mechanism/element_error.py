"""Exception for an invalid element of a mechanism."""

from __future__ import annotations


class ElementError(ValueError):
    """Error for an element that cannot be part of the mechanism.

    key: path of the element in the document, for example `links.rack.radius`. The command that read
    the file adds the file's name and the line.
    """

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)
