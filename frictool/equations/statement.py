"""What an equation is not: a condition, or a law by its name. Its terms, which measure the same,
are checked all the same."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.equations.expression import Term


@dataclass(frozen=True)
class Condition:
    """A sentence for people, and LaTeX of its formula. terms, unit: what has to be of one unit."""

    text: str
    latex: str
    unit: str
    terms: tuple[Term, ...] = ()
    key: str = ""
    source: str = ""
