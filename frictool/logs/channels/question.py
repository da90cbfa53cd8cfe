"""What a log leaves open when its columns are guessed: somebody who knows the rig has to answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Question:
    """What the log does not tell of the column of a channel.

    key: `column` or `unit`; candidates: what fits; why: the reason why the log does not tell, for people.
    """

    channel: str
    key: str
    candidates: tuple[str, ...]
    why: str

    @property
    def note(self) -> str:
        """The comment beside the key."""
        return f"fill in {self.key} {alternatives(self.candidates)}: {self.why}"


def alternatives(names: Sequence[str]) -> str:
    """Return `a, b or c`."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
