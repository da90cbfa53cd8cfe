"""Long format of a text file: a row for each value, with the name of its signal in a column."""

from __future__ import annotations

import re

from frictool.logs.text.text_layout import TextLayout

SIGNALS = re.compile(r"tags?|tagname|var(iable)?(name)?|point(name)?|signal(name)?|item|name")
VALUES = re.compile(r"(tag|var|point)?(value|val|wert)")
TIMES = re.compile(r"(local|utc)?(time|date|zeit|datum)\w*")


def pivot_advice(layout: TextLayout) -> str | None:
    """Return a message with the pandas command for a file in long format; None for other files."""
    words = {re.sub(r"[^a-z]", "", name.lower()): name for name in layout.names}
    columns = [
        next((name for word, name in words.items() if form.fullmatch(word)), None)
        for form in (VALUES, TIMES, SIGNALS)
    ]
    if layout.clock in layout.names:
        columns[1] = layout.clock
    if None in columns:
        return None
    table = ", ".join(map(repr, columns))
    dialect = "" if layout.delimiter == "," else f", sep={layout.delimiter!r}"
    dialect += "" if layout.mark == "." else f", decimal={layout.mark!r}"
    return (
        "has a row for each value, not a column for each signal; pivot it with pandas: "
        f"read_csv(FILE{dialect}).pivot_table({table}).to_csv('wide.csv')"
    )
