"""Load hypotheses of `explanation_search`, and the load terms of the accepted hypotheses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from frictool.documents.load_terms import LoadTerms, RipplePeriod, Term
from frictool.documents.quantity import Quantity
from frictool.identify.rows.effects import WHAT, Hypothesis
from frictool.identify.rows.load_terms import DECLARED, DIRECTION, GRAVITY, SPRING, TERMS

LOADS = (
    Hypothesis(
        SPRING,
        TERMS[SPRING],
        WHAT["spring"],
        "remove the spring, or declare load.terms: [offset, spring]",
        is_load=True,
        needs_position=True,
    ),
    Hypothesis(
        GRAVITY,
        TERMS[GRAVITY],
        WHAT["gravity"],
        "turn the axis by 90 deg, or declare load.terms: [offset, gravity]",
        is_load=True,
        needs_position=True,
    ),
    Hypothesis(
        DIRECTION,
        TERMS[DIRECTION],
        WHAT["viscous_by_direction"],
        "declare load.terms: [offset, viscous_by_direction]",
    ),
)

# a spring of negative stiffness, which `auto` reports but does not use: it pushes the axis away
# from its equilibrium, and a controller designed for it relies on this sign
UNSTABLE_SPRING = replace(
    LOADS[0],
    what="a spring of negative stiffness",
    settle="record strokes over the whole travel, or declare load.terms: [offset, spring]",
)


def declared_term(one: Hypothesis) -> Term:
    """Return the name by which the bench declares a hypothesis in `load.terms`."""
    return cast(Term, DECLARED.get(one.term, one.term))


def wave_numbers(load: LoadTerms | None) -> tuple[float, ...]:
    """Return the wave numbers of the ripple in a load, 1/rad | 1/m; empty without a ripple."""
    if load is None or load.ripple is None:
        return ()
    return tuple(2.0 * np.pi * one / load.ripple.per.value for one in load.ripple.numbers)


def harmonic(term: str, what: str = "a ripple over the position", settle: str = "") -> Hypothesis:
    """Return the hypothesis of one harmonic of a ripple.

    `term`, `what` and `settle` are the fields of `Hypothesis`.
    """
    return Hypothesis(term, TERMS[term], what, settle, is_load=True)


@dataclass(frozen=True)
class Structure:
    """Load terms of a fit, and the wave number [1/rad | 1/m] of each ripple among these terms."""

    terms: tuple[str, ...] = ()
    waves: tuple[float, ...] = ()

    def load(self, rotary: bool) -> LoadTerms:
        """Return these terms and an offset in the form of the key `load` of bench.yaml."""
        terms = (cast(Term, DECLARED.get(term, term)) for term in self.terms)
        per = 2.0 * np.pi if rotary else 1.0
        cycles = tuple(wave * per / (2.0 * np.pi) for wave in self.waves)
        unit = "rad" if rotary else "m"
        ripple = RipplePeriod(cycles[0], Quantity(per, unit=unit), cycles[1:]) if cycles else None
        return LoadTerms(tuple(dict.fromkeys(("offset", *terms))), ripple)
