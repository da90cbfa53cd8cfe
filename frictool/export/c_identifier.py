"""Conversion of a document's free text to C identifiers and comments."""

from __future__ import annotations

import re

# standard headers: the compiler would include an exported file of the same name instead
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
    """Return a prefix for C identifiers and file names.

    The prefix consists of lower-case ASCII letters, digits and underscores.

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
    r"""Return one line of printable ASCII for a comment.

    The characters / * \ ? become _, because these characters can open, end or continue a comment.
    """
    return re.sub(r"[^ -~]|[/*\\?]", "_", text)
