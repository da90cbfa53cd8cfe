"""Origin of exported files."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExportOrigin:
    """SHA-256 digest of the exported document, and command line that exported it."""

    sha256: str
    command: str
