"""Messages about columns that were guessed from a log."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frictool.documents.starting_documents import StartingRig


def preset_text(start: StartingRig) -> str:
    """Return the words that name the preset of a log; empty without a preset."""
    return "" if start.preset is None else f" with the preset {start.preset}"


def question_lines(start: StartingRig) -> list[str]:
    """Return the lines on unreadable columns, and on columns and units to fill in."""
    lines = [
        f"{column!r} cannot be read and is left out: {reason}"
        for column, reason in start.unreadable.items()
    ]
    if start.questions:
        lines.append(f'{start.log} does not determine all values; replace "?" in bench.yaml:')
        lines += [f"  columns.{channel}: {note}" for channel, note in start.questions.items()]
    return lines
