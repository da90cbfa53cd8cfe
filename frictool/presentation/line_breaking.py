"""Joining of lines of text, with line breaks in long lines."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

LONGEST = 240  # characters, longest line
INDENT = 4  # characters, extra indent of continuation lines


def bounded(lines: Iterable[str], longest: int = LONGEST) -> str:
    """Join lines; break each line that is longer than `longest` characters between words."""
    broken = list[str]()
    for line in lines:
        if len(line) <= longest:
            broken.append(line)
            continue
        indent = " " * (len(line) - len(line.lstrip()) + INDENT)
        broken += textwrap.wrap(
            line, longest, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
        )
    return "\n".join(broken)
