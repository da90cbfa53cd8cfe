"""A document's free text as C: identifiers, and text that cannot end a comment."""

from __future__ import annotations

import re

# a file called like one of these would stand in for the compiler's own header
STANDARD_HEADERS = frozenset(
    {
        "assert",
        "complex",
        "ctype",
        "errno",
        "fenv",
        "float",
        "inttypes",
        "iso646",
        "limits",
        "locale",
        "math",
        "setjmp",
        "signal",
    }
    | {
        "stdarg",
        "stdbool",
        "stddef",
        "stdint",
        "stdio",
        "stdlib",
        "string",
        "tgmath",
        "time",
        "wchar",
        "wctype",
    }
)


def c_identifier(name: str) -> str:
    """A prefix for C identifiers and file names: lower-case ASCII letters, digits and underscores.

    >>> c_identifier("Clutch 2: speed")
    'clutch_2_speed'
    >>> c_identifier("2 rad")
    'controller_2_rad'
    """
    words = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    if not words:
        return "controller"
    return f"controller_{words}" if words[0].isdigit() or words in STANDARD_HEADERS else words


def comment_text(text: str) -> str:
    """One line of printable ASCII without what ends, opens or continues a comment: / * \\ ? become
    _."""
    return re.sub(r"[^ -~]|[/*\\?]", "_", text)
