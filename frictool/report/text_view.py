"""Text view of the verdict for the terminal."""

from __future__ import annotations

import click

from frictool.presentation.sections import plain
from frictool.report.requirement import Requirement, Verdict

COLOURS = {
    "MET": "green",
    "NOT MET": "red",
    "UNDECIDED": "yellow",
    "pass": "green",
    "fail": "red",
    "undecided": "yellow",
}
LEAST = (16, 11, 11, 0)  # widths of the columns of a short table


def lines(verdict: Verdict, colour: bool = False) -> list[str]:
    """Return one line per requirement, the remarks, then the verdict."""
    rows = [tuple(map(plain, _cells(requirement))) for requirement in verdict.requirements]
    widths = [max([least, *(len(row[k]) for row in rows)]) for k, least in enumerate(LEAST)]
    shown = [
        _painted(f"{requirement.outcome:<12}", requirement.outcome, colour)
        + "  ".join(map(str.ljust, row, widths)).rstrip()
        for requirement, row in zip(verdict.requirements, rows, strict=True)
    ]
    remarks = [plain(f"warning: {remark}") for remark in verdict.remarks]
    return [*shown, *remarks, _painted(plain(verdict.headline), verdict.state, colour)]


def _painted(text: str, outcome: str, colour: bool) -> str:
    return click.style(text, fg=COLOURS[outcome], bold=True) if colour else text


def _cells(requirement: Requirement) -> tuple[str, str, str, str]:
    limit = f"{requirement.relation} {requirement.limit_text}"
    return requirement.title, requirement.value_text or "-", limit, requirement.remark
