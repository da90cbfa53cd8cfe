"""Origin of exported files."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExportOrigin:
    """Digest of the controller document, and the command line for the provenance."""

    sha256: str
    command: str
