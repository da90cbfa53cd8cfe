"""Questions that remain when the columns of a log are guessed, for somebody who knows the rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class ColumnQuestion:
    """Open question on the column or the unit of a channel.

    key: `column` or `unit`; candidates: the columns or units that fit; why: the reason for the
    question, as text.
    """

    channel: str
    key: str
    candidates: tuple[str, ...]
    why: str

    @property
    def note(self) -> str:
        """Return the comment beside the key in the bench."""
        return f"fill in {self.key} {alternatives(self.candidates)}: {self.why}"


def alternatives(names: Sequence[str]) -> str:
    """Return `a, b or c`."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
