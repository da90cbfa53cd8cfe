"""Where exported files come from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExportOrigin:
    """The digest of the controller document, and the command line for the provenance."""

    sha256: str
    command: str
