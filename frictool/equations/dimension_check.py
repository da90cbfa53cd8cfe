"""Dimension check: all terms of a sum must have the same dimension.

The dimension of a term is the product of the units of its symbols. A radian is dimensionless: a
torque per radian times an angle is a torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictool.documents.quantity import dimension_of
from frictool.equations.expression import Atom, Equation, Term
from frictool.plant.mechanism.element_error import ElementError


def check_equation(equation: Equation) -> int:
    """Check the dimensions of an equation; return the number of its terms.

    Raises ElementError for the first term whose dimension differs from the unit of the equation.
    """
    of = Term(((equation.of, 1),))
    return check_sum(
        [*(term.times(of).of(term.element) for term in equation.coefficients), *equation.right],
        equation.unit,
        equation,
    )


def check_sum(terms: list[Term], unit: str, within: Equation | None = None) -> int:
    """Check that all terms of a sum have the dimension of `unit`; return the number of terms."""
    wanted = dimension_of(unit)
    for term in terms:
        measured = dimension(term)
        if measured != wanted:
            where = "" if within is None else f" of {within.text}"
            key = term.element or ("" if within is None else within.key)
            raise ElementError(
                key,
                f"the term {term.text}{where} has the dimension {_dimension_text(measured)}; "
                f"allowed: the dimension of {unit or '1'}, the unit of the other terms",
            )
    return len(terms)


def dimension(term: Term) -> Any:
    """Return the exponent of each base dimension of a term."""
    out = dimension_of("")
    for atom, power in term.factors:
        out = out * _of_atom(atom) ** power
    return out


def _of_atom(atom: Atom) -> Any:
    if atom.made is None:
        return dimension_of(atom.unit)
    first, *others = (dimension(term) for term in atom.made)
    if any(other != first for other in others):
        raise ElementError(
            atom.made[0].element,
            f"{atom.text} adds terms of different dimensions: {_dimension_text(first)} and "
            f"{_dimension_text(others[0])}",
        )
    return first


def _dimension_text(powers: Mapping[str, float]) -> str:
    return (
        " ".join(
            f"{name}^{power:g}" if power != 1 else name for name, power in sorted(powers.items())
        )
        or "a plain number"
    )
