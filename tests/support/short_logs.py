"""First part of a sample log, where a test does not depend on the length of its log."""

from __future__ import annotations

from studies.rigs.identification_rigs import ROOT

ROWS = 10_000  # strokes at every speed, and several ramps


def first_lines(log: str, rows: int = ROWS) -> list[str]:
    """The header and the first rows of a sample log, without line ends."""
    return (ROOT / "sample_logs" / log).read_text().splitlines()[: rows + 1]


def first_part(log: str, rows: int = ROWS) -> str:
    """The text of the first rows of a sample log, with its header."""
    return "\n".join((*first_lines(log, rows), ""))
