"""Messages about the columns of a log whose meaning was guessed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictool.documents.name_list import listed
from frictool.logs.channels.column_names import quantities

if TYPE_CHECKING:
    from frictool.documents.starting_documents import StartingRig

LONGEST_NAMES = 60  # characters of the names of unreadable columns in a line


def preset_text(start: StartingRig) -> str:
    """Return text that names the drive or robot whose log format was recognised; else ""."""
    return "" if start.preset is None else f" with the preset {start.preset}"


def question_lines(start: StartingRig) -> list[str]:
    """Return lines of text on columns that cannot be read, and on columns and units to fill in.

    An unreadable column is listed only if its name is a known name of a quantity.
    """
    reasons: dict[str, list[str]] = {}
    for column, reason in start.unreadable.items():
        if not quantities(column):
            continue
        reasons.setdefault(reason.replace(f"column {column!r}: ", ""), []).append(repr(column))
    lines = [
        f"cannot be read and left out: {listed(columns, LONGEST_NAMES)}: {reason}"
        for reason, columns in reasons.items()
    ]
    if start.questions:
        lines.append(f'{start.log} does not determine all values; replace "?" in bench.yaml:')
        lines += [f"  columns.{channel}: {note}" for channel, note in start.questions.items()]
    return lines
