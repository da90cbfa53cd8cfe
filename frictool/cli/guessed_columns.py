"""Messages about columns that were guessed from a log."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frictool.documents.starting_documents import StartingRig


def question_lines(start: StartingRig) -> list[str]:
    """Return the lines that list the columns and units to fill in; empty if there are none."""
    lines = [f"  columns.{channel}: {note}" for channel, note in start.questions.items()]
    return (
        [f'{start.log} does not determine all values; replace "?" in bench.yaml:', *lines]
        if lines
        else []
    )
