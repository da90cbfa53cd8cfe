"""Ratio of a link as a formula, and transfer of the effort from the second end to the first end.

q_b = ratio q_a        effort lambda on b, -p lambda on a        p = ratio without losses
p = ratio/eta for power from a to b (lambda v_b > 0)
p = ratio eta_back for power from b to a
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from frictool.adapters.mechanism.transmissions import Transmitting, back_efficiency, tangent_of_lead
from frictool.documents.mechanism import Belt, Coupling, Gear, Hydraulic, Rack, Screw
from frictool.documents.quantity import si_unit
from frictool.equations.expression import Atom, Equation, Term, symbol
from frictool.equations.notation import RATES, Notation, function, indexed_latex

LOSS_SOURCES = {"gear": "(2.3)", "rack": "(2.20)", "screw": "(2.12)"}


@dataclass(frozen=True)
class EffortTransfer:
    """Transfer of the effort lambda at the second end b to the first end a.

    The effort -p lambda acts on the block a.

    - factor: p
    - additional: effort W that also acts on the block a, for the screw of thesis (2.12)
    - equations: equations of p and W
    - reason: sentence that states whether the second end can drive the first (thesis 2.1.6); ""
      without losses
    """

    factor: Term
    additional: Term | None = None
    equations: tuple[Equation, ...] = ()
    reason: str = ""


def ratio_of(name: str, link: Transmitting, notation: Notation) -> tuple[Term, Term]:
    """Return the signed ratio q_b/q_a, and (deformation of a compliant link)/(motion q_b).

    The second value is the pulley radius for a belt, and 1 for other links.
    """
    key = f"links.{name}"
    match link:
        case Gear():
            ratio = notation.number("r", "r", name, link.ratio, f"{key}.ratio")
            return (ratio if link.internal else ratio.negative()), Term()
        case Belt():
            first = notation.parameter("r_a", "r_a", name, link.radius_a, f"{key}.radius_a")
            second = notation.parameter("r_b", "r_b", name, link.radius_b, f"{key}.radius_b")
            ratio = first.times(second.inverse())
            return (ratio.negative() if link.crossed else ratio), second
        case Screw():
            lead = _lead(name, link, notation)
            return (lead.negative() if link.left_handed else lead).of(key), Term()
        case Rack():
            radius = notation.parameter("r", "r", name, link.radius, f"{key}.radius")
            return (radius.negative() if link.reversed else radius), Term()
        case Hydraulic():
            area_a = notation.parameter("S_a", "S_a", name, link.area_a, f"{key}.area_a")
            area_b = notation.parameter("S_b", "S_b", name, link.area_b, f"{key}.area_b")
            return area_a.times(area_b.inverse()), Term()
        case Coupling():
            return Term(), Term()


def _lead(name: str, link: Screw, notation: Notation) -> Term:
    if link.lead is None:
        return _radius(name, link, notation).times(_tangent(name, link, notation, ""))
    turn = symbol("2 pi", r"2\pi", value=2.0 * math.pi)
    return notation.parameter("lead", r"\ell", name, link.lead, f"links.{name}.lead").times(
        turn.inverse()
    )


def _radius(name: str, link: Screw, notation: Notation) -> Term:
    return notation.parameter("R", "R", name, link.radius, f"links.{name}.radius")


def _tangent(name: str, link: Screw, notation: Notation, sign: str) -> Term:
    angle = math.atan(tangent_of_lead(f"links.{name}", link))
    if link.lead_angle is not None:
        alpha = notation.parameter(
            "alpha", r"\alpha", name, link.lead_angle, f"links.{name}.lead_angle"
        ).factors[0][0]
    else:
        assert link.lead is not None
        lead = notation.parameter("lead", r"\ell", name, link.lead, f"links.{name}.lead")
        round_once = symbol("2 pi", r"2\pi", value=2.0 * math.pi).times(
            _radius(name, link, notation)
        )
        steep = lead.times(round_once.inverse())
        alpha = Atom(f"atan({steep.text})", rf"\arctan{steep.latex}", "rad", angle)
    if not sign:
        return function("tan", r"\tan", alpha.text, alpha.latex, value=math.tan(angle))
    assert link.friction_coefficient is not None
    mu = notation.number(
        "mu", r"\mu", name, link.friction_coefficient, f"links.{name}.friction_coefficient"
    ).factors[0][0]
    phi = math.atan(link.friction_coefficient)
    value = math.tan(angle + phi if sign == "+" else angle - phi)
    return function(
        "tan",
        r"\tan",
        f"{alpha.text} {sign} atan({mu.text})",
        rf"{alpha.latex} {sign} \arctan {mu.latex}",
        value=value,
    )


def effort_transfer(
    name: str, link: Transmitting, notation: Notation, ratio: Term, force: Term
) -> EffortTransfer:
    """Return the transfer of `force`, the effort lambda at the second end, to the first end."""
    efficiency: float | None = getattr(link, "efficiency", None)
    if isinstance(link, Screw) and link.friction_coefficient is not None:
        if link.friction_form == "thesis":
            return _as_printed(name, link, notation, ratio, force, link.friction_coefficient)
        return _by_thread(name, link, notation, ratio, link.friction_coefficient)
    stated: float | None = getattr(link, "efficiency_back", None)
    if efficiency is None or (efficiency == 1.0 and stated is None):
        return EffortTransfer(ratio)
    key = f"links.{name}"
    eta = notation.number("eta", r"\eta", name, efficiency, f"{key}.efficiency")
    value = back_efficiency(efficiency, stated)
    returned = notation.number(
        "eta_back",
        r"\eta_\mathrm{back}",
        name,
        value,
        f"{key}.efficiency" if stated is None else f"{key}.efficiency_back",
    )
    reason = f"eta_back = {value:.6g} {'>' if value > 0.0 else '<='} 0" + (
        "" if stated is not None else " (2 - 1/eta)"
    )
    return _by_direction(
        name, link, notation, ratio, ratio.times(eta.inverse()), ratio.times(returned), reason
    )


def _by_thread(
    name: str, link: Screw, notation: Notation, ratio: Term, mu: float
) -> EffortTransfer:
    radius = _radius(name, link, notation).times(Term(sign=ratio.sign))
    forth, back = (radius.times(_tangent(name, link, notation, sign)) for sign in "+-")
    steep = tangent_of_lead(f"links.{name}", link)
    return _by_direction(
        name,
        link,
        notation,
        ratio,
        forth,
        back,
        f"mu = {mu:g} {'<' if mu < steep else '>='} tan(alpha) = {steep:.6g}",
    )


def _by_direction(
    name: str,
    link: Transmitting,
    notation: Notation,
    ratio: Term,
    forth: Term,
    back: Term,
    reason: str,
) -> EffortTransfer:
    key = f"links.{name}"
    atom = Atom(f"p_{name}", indexed_latex("p", name), made=(ratio,))
    a, b = link.between
    first, second = (notation.kinds[end] for end in (a, b))
    unit = "" if first == second else f"{RATES[second][0]}/{RATES[first][0]}"
    power = f"lambda_{name} {notation.speed(b).text}"
    source = LOSS_SOURCES.get(str(link.__struct_config__.tag), "")
    equations = (
        Equation(
            (Term(),),
            atom,
            (forth.of(key),),
            unit,
            key,
            f"{forth.number:.6g} where {power} > 0 ({a} drives)",
            source,
        ),
        Equation(
            (Term(),),
            atom,
            (back.of(key),),
            unit,
            key,
            f"{back.number:.6g} where {power} < 0 ({b} drives)",
        ),
    )
    can = (
        "back-drivable"
        if back.number * ratio.number > 0.0
        else f"self-locking, {b} cannot drive {a}"
    )
    return EffortTransfer(Term(((atom, 1),)), None, equations, f"{name} is {can}: {reason}")


def _as_printed(
    name: str, link: Screw, notation: Notation, ratio: Term, force: Term, mu: float
) -> EffortTransfer:
    """Return the effort transfer of a screw with the friction of thesis (2.12).

    The friction is W = mu |R lambda - u tan(alpha)| sign(omega).

    - mu: friction coefficient
    - R: radius
    - lambda: effort at the nut
    - u: effort of the sources on the screw
    - alpha: lead angle
    - omega: speed of the screw
    """
    key = f"links.{name}"
    screw = link.between[0]
    pressed = _radius(name, link, notation).times(force)
    steep = tangent_of_lead(key, link)
    driven = symbol(f"u_{screw}", indexed_latex("u", screw), si_unit("effort", "rotary"))
    turned = driven.times(_tangent(name, link, notation, ""))
    speed = notation.speed(screw)
    inner = Atom(
        f"|{pressed.text} - {turned.text}| sign({speed.text})",
        rf"\left|{pressed.latex} - {turned.latex}\right|"
        rf"\,\mathrm{{sign}}\left({speed.latex}\right)",
        made=(pressed, turned),
    )
    extra = notation.effort("W", name, "rotary").of(key)
    lost = notation.number("mu", r"\mu", name, mu, f"{key}.friction_coefficient").times(
        Term(((inner, 1),))
    )
    when = f"u_{screw}: effort of the sources on {screw}"
    stated = Equation(
        (Term(),),
        extra.factors[0][0],
        (lost.of(key),),
        si_unit("effort", "rotary"),
        key,
        when,
        "(2.12)",
    )
    can = "back-drivable" if mu < steep else f"self-locking, {link.between[1]} cannot drive {screw}"
    return EffortTransfer(
        ratio,
        extra,
        (stated,),
        f"{name} is {can}: mu = {mu:g} {'<' if mu < steep else '>='} tan(alpha) = {steep:.6g}",
    )
