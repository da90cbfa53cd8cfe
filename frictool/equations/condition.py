"""Condition: a statement that is no equation, such as a law that has only a name."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.equations.expression import Term


@dataclass(frozen=True)
class Condition:
    """Sentence with the LaTeX of its formula; the dimension check covers `terms`, all in `unit`."""

    text: str
    latex: str
    unit: str
    terms: tuple[Term, ...] = ()
    key: str = ""
    source: str = ""
