"""Questions about a log's columns that only a person who knows the rig can answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class ColumnQuestion:
    """Question to the user about the column or the unit of a channel.

    channel: name of the channel, or `time`.
    key: key of bench.yaml that the user has to fill in: `column`, `unit` or `scale`.
    candidates: columns, units or scales from which the user chooses.
    why: reason why the file does not answer the question.
    """

    channel: str
    key: str
    candidates: tuple[str, ...]
    why: str

    @property
    def note(self) -> str:
        """Return the comment that the generated bench.yaml shows next to the key."""
        return f"fill in {self.key} {alternatives(self.candidates)}: {self.why}"


def alternatives(names: Sequence[str]) -> str:
    """Join the names to a text such as `a, b or c`."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
