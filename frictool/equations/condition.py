"""Conditions: statements that are not equations, such as limits or inequalities."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.equations.expression import Term


@dataclass(frozen=True)
class Condition:
    """Condition as text and as LaTeX; all `terms` must have the unit `unit`.

    - key: key of the condition's element in the document
    - source: number of the equation in the thesis
    """

    text: str
    latex: str
    unit: str
    terms: tuple[Term, ...] = ()
    key: str = ""
    source: str = ""
