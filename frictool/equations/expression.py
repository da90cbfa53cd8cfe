"""Algebraic expressions of the equations: sums of signed products of symbols.

Atom      symbol in text and LaTeX, with its unit; a parameter also has a value
Term      sign * product of atoms to integer powers
Equation  (sum of terms) times one atom = sum of terms
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Atom:
    """Symbol of an equation, as text and LaTeX.

    - unit: SI unit
    - value: value of a parameter in SI
    - made: terms of the sum that the symbol abbreviates; None if the symbol is not an abbreviation
    """

    text: str
    latex: str
    unit: str = ""
    value: float | None = None
    made: tuple[Term, ...] | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Term:
    """Product sign * atom^power * ...; without atoms, the sign alone.

    element: key of the term's element in the document, such as `links.screw`, or "".
    """

    factors: tuple[tuple[Atom, int], ...] = ()
    sign: int = 1
    element: str = ""

    def times(self, other: Term) -> Term:
        """Return the product of two terms, with common factors cancelled.

        The product has the `element` of `other` or, if this is empty, the `element` of the first
        term.
        """
        powers: dict[Atom, int] = {}
        for atom, power in (*self.factors, *other.factors):
            powers[atom] = powers.get(atom, 0) + power
        kept = tuple((atom, power) for atom, power in powers.items() if power)
        return Term(kept, self.sign * other.sign, other.element or self.element)

    def inverse(self) -> Term:
        """Return 1/term."""
        return replace(self, factors=tuple((atom, -power) for atom, power in self.factors))

    def negative(self) -> Term:
        """Return the term with its sign reversed."""
        return replace(self, sign=-self.sign)

    def of(self, element: str) -> Term:
        """Return a copy of the term with the element `element`."""
        return replace(self, element=element)

    @property
    def number(self) -> float:
        """Return the product of the sign and of all atoms that have values."""
        product = float(self.sign)
        for atom, power in self.factors:
            product *= 1.0 if atom.value is None else atom.value**power
        return product

    @property
    def rest(self) -> Term:
        """Return the product of the atoms that have no value."""
        return Term(tuple((atom, power) for atom, power in self.factors if atom.value is None))

    @property
    def text(self) -> str:
        """Return the term as text, without its sign."""
        above = (
            " ".join(_power(atom.text, power) for atom, power in self.factors if power > 0) or "1"
        )
        below = [_power(atom.text, -power) for atom, power in self.factors if power < 0]
        return (
            above
            if not below
            else f"{above}/{below[0]}"
            if len(below) == 1 and " " not in below[0].partition("(")[0]
            else f"{above}/({' '.join(below)})"
        )

    @property
    def latex(self) -> str:
        """Return the term in LaTeX, without its sign."""
        above = (
            r"\,".join(
                _power(atom.latex, power, "^{%d}") for atom, power in self.factors if power > 0
            )
            or "1"
        )
        below = r"\,".join(
            _power(atom.latex, -power, "^{%d}") for atom, power in self.factors if power < 0
        )
        return rf"\frac{{{above}}}{{{below}}}" if below else above


@dataclass(frozen=True)
class Equation:
    """Equation (sum of `coefficients`) times `of` = sum of `right`.

    - unit: unit of every term
    - key: key of the equation's element in the document
    - when: condition under which the equation is valid
    - source: number of the equation in the thesis
    """

    coefficients: tuple[Term, ...]
    of: Atom
    right: tuple[Term, ...]
    unit: str
    key: str = ""
    when: str = ""
    source: str = ""

    @property
    def text(self) -> str:
        """Return the equation as text."""
        many = len(self.coefficients) > 1
        factor = (
            f"({sum_text(self.coefficients)}) "
            if many
            else sum_text(self.coefficients) + " "
            if self.coefficients[0].factors
            else ""
        )
        return f"{factor}{self.of.text} = {sum_text(self.right)}"

    @property
    def latex(self) -> str:
        """Return the equation in LaTeX."""
        many = len(self.coefficients) > 1
        inner = sum_latex(self.coefficients)
        factor = (
            rf"\left({inner}\right)\,"
            if many
            else inner + r"\,"
            if self.coefficients[0].factors
            else ""
        )
        return f"{factor}{self.of.latex} = {sum_latex(self.right)}"

    @property
    def numbers(self) -> str:
        """Return the equation with parameters replaced by their values; like terms are added."""
        factor = _valued(self.coefficients)
        whole = "" if factor == "1" else f"({factor}) " if " " in factor else f"{factor} "
        return f"{whole}{self.of.text} = {_valued(self.right)}"


def symbol(text: str, latex: str, unit: str = "", value: float | None = None) -> Term:
    """Return a term that consists of one symbol."""
    return Term(((Atom(text, latex, unit, value), 1),))


def product(terms: Iterable[Term]) -> Term:
    """Return the product of the terms; 1 for no terms."""
    out = Term()
    for term in terms:
        out = out.times(term)
    return out


def sum_text(terms: Sequence[Term]) -> str:
    """Return the text of a sum; "0" if it is empty."""
    return _joined((term.sign < 0, term.text) for term in terms)


def sum_latex(terms: Sequence[Term]) -> str:
    """Return the LaTeX of a sum; "0" if it is empty."""
    return _joined((term.sign < 0, term.latex) for term in terms)


def _valued(terms: Sequence[Term]) -> str:
    added: dict[Term, float] = {}
    for term in terms:
        added[term.rest] = added.get(term.rest, 0.0) + term.number
    return _joined((value < 0.0, _scaled(abs(value), term)) for term, value in added.items())


def _scaled(value: float, term: Term) -> str:
    if not term.factors:
        return f"{value:.6g}"
    above = Term(tuple((atom, power) for atom, power in term.factors if power > 0))
    below = term.text.partition("/")[2] if not above.factors else ""
    if below:
        return f"{value:.6g}/{below}"
    return term.text if value == 1.0 else f"{value:.6g} {term.text}"


def _joined(parts: Iterable[tuple[bool, str]]) -> str:
    out = ""
    for negative, text in parts:
        out += (" - " if negative else " + ") + text if out else ("-" if negative else "") + text
    return out or "0"


def _power(base: str, power: int, form: str = "^%d") -> str:
    if power == 1:
        return base
    # a name, or a function with its argument, needs no parentheses
    single = " " not in base.partition("(")[0] and not base.startswith(("(", "|", r"\left"))
    return (base if single else f"({base})") + form % power
