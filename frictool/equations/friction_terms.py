"""Terms of friction laws; a law without a closed form becomes one term with the law's name."""

from __future__ import annotations

from frictool.adapters.mechanism.bearing_friction import si_parameters
from frictool.documents.mechanism import FrictionOf
from frictool.documents.quantity import Quantity
from frictool.equations.expression import Atom, Term
from frictool.equations.notation import Notation, function, roman
from frictool.friction.law_registry import LAWS


def friction_terms(name: str, element: FrictionOf, notation: Notation) -> list[Term]:
    """Return the terms of the friction F in slip; F opposes the motion.

    A law without `slip_terms` gives one term: the name of the law as a function of speed and
    parameters.
    """
    symbols = _symbols(name, element, notation)
    speed = notation.speed(element.on)
    direction = function("sign", r"\mathrm{sign}", speed.text, speed.latex)
    law = LAWS[element.law]
    made = {
        "coulomb": lambda: symbols["coulomb"].times(direction),
        "stribeck": lambda: _fall(symbols, speed).times(direction),
        "viscous": lambda: symbols["viscous"].times(speed),
    }
    if law.slip_terms:
        return [made[term]() for term in law.slip_terms]
    named = Atom(
        f"{law.name}({speed.text}; {', '.join(term.text for term in symbols.values())})",
        rf"{roman(law.name)}\left({speed.latex}; "
        rf"{', '.join(term.latex for term in symbols.values())}\right)",
        made=(symbols["coulomb"],),
    )
    return [Term(((named, 1),))]


def _fall(symbols: dict[str, Term], speed: Term) -> Term:
    over = speed.times(symbols["stribeck_velocity"].inverse())
    breakaway, coulomb, delta = (
        symbols["breakaway"],
        symbols["coulomb"],
        symbols["stribeck_exponent"],
    )
    drop = Atom(
        f"({breakaway.text} - {coulomb.text})",
        rf"\left({breakaway.latex} - {coulomb.latex}\right)",
        made=(breakaway, coulomb),
    )
    one = Term()
    fall = Atom(
        f"exp(-|{over.text}|^{delta.text})",
        rf"e^{{-\left|{over.latex}\right|^{{{delta.latex}}}}}",
        made=(one, over, delta),
    )
    return Term(((drop, 1), (fall, 1)))


def dry_level(name: str, element: FrictionOf, notation: Notation) -> Term | None:
    """Return the largest friction at rest; None if it is 0 or depends on an internal state."""
    law = LAWS[element.law]
    if law.approximation or law.kind == "dynamic":
        return None
    symbols = _symbols(name, element, notation)
    return symbols.get("breakaway", symbols["coulomb"])


def _symbols(name: str, element: FrictionOf, notation: Notation) -> dict[str, Term]:
    key = f"links.{name}"
    kind = notation.kinds[element.on]
    quantities = si_parameters(key, element, kind)
    out = {}
    for parameter in LAWS[element.law].parameters:
        quantity = quantities.get(parameter.name)
        if quantity is None and parameter.default is not None:
            quantity = Quantity(parameter.default, unit=parameter.unit(kind))
        if quantity is not None:
            text, latex = parameter.letters or (parameter.name, roman(parameter.name))
            out[parameter.name] = notation.parameter(
                text, latex, name, quantity, f"{key}.parameters.{parameter.name}"
            )
    return out
