"""Escapes for control characters in the texts of files, because a terminal would execute them."""

from __future__ import annotations

import re

# C0 except tab and line feed, single carriage returns, DEL, C1, line separators, and characters
# that change the writing direction
_UNSAFE = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]|\r(?!\n)"
)


def printable(text: str) -> str:
    r"""Return the text with an escape sequence in place of each control character.

    >>> printable("log\x1b[31m.csv")
    'log\\x1b[31m.csv'
    """
    return _UNSAFE.sub(lambda match: _escape(match.group()), text)


def printable_json(text: str) -> str:
    """Return a JSON text with the same meaning but without control characters."""
    return _UNSAFE.sub(lambda match: f"\\u{ord(match.group()):04x}", text)


def _escape(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
