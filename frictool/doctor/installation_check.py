"""What is found of one part of an installation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

State = Literal["ok", "note", "wrong"]


@dataclass(frozen=True)
class InstallationCheck:
    """ok; note: frictool works, with something less; wrong: it does not. remedy: what to try.
    facts: the machine's view of `found`."""

    name: str
    state: State
    found: str
    remedy: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
