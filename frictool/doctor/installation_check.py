"""Finding about one part of an installation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

State = Literal["ok", "note", "wrong"]


@dataclass(frozen=True)
class InstallationCheck:
    """Finding about one part.

    state: `ok`; `note`, if frictool works with restrictions; `wrong`, if it does not work. found:
    as text. remedy: advice. facts: finding as data.
    """

    name: str
    state: State
    found: str
    remedy: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
