"""Finding about one part of an installation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

State = Literal["ok", "note", "wrong"]


@dataclass(frozen=True)
class InstallationFinding:
    """State of one part of the installation.

    - state: `ok`; `note` if frictool works with restrictions; `wrong` if it does not work
    - finding: description of the state as text
    - remedy: advice for the user
    - facts: data of `finding` as values for JSON
    """

    name: str
    state: State
    finding: str
    remedy: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
