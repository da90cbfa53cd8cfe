"""Text view of the verdict for the terminal."""

from __future__ import annotations

import click

from frictool.presentation.sections import plain
from frictool.report.requirement import Requirement, Verdict, number, unit_shown

COLOURS = {
    "MET": "green",
    "NOT MET": "red",
    "UNDECIDED": "yellow",
    "pass": "green",
    "fail": "red",
    "undecided": "yellow",
}


def lines(verdict: Verdict, colour: bool = False) -> list[str]:
    """Return one line per requirement, the remarks, then the verdict."""
    shown = [_line(requirement, colour) for requirement in verdict.requirements]
    remarks = [plain(f"warning: {remark}") for remark in verdict.remarks]
    return [*shown, *remarks, _painted(plain(verdict.headline), verdict.state, colour)]


def _painted(text: str, outcome: str, colour: bool) -> str:
    return click.style(text, fg=COLOURS[outcome], bold=True) if colour else text


def _line(requirement: Requirement, colour: bool) -> str:
    outcome = _painted(f"{requirement.outcome:<12}", requirement.outcome, colour)
    value = (
        f"{number(requirement.value)} {unit_shown(requirement.unit)}"
        if requirement.value is not None
        else "-"
    )
    limit = f"{requirement.relation} {number(requirement.limit)} {unit_shown(requirement.unit)}"
    remark = "; ".join(part for part in (str(requirement.where or ""), requirement.reason) if part)
    name = requirement.name.replace("_", " ")
    return outcome + plain(f"{name:<18}{value:<13}{limit:<13}{remark}".rstrip())
