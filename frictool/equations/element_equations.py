"""Equations of springs, cams, friction, end stops and sources (thesis 2.23 and section 2.3).

link_equations.py has the equations of the transmitting links.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from frictool.documents.mechanism import GROUND, Cam, Curve, FrictionOf, Level, Source, Spring, Stop
from frictool.documents.quantity import Quantity, si_unit
from frictool.equations.condition import Condition
from frictool.equations.expression import Atom, Equation, Term, symbol
from frictool.equations.friction_terms import dry_level, friction_terms
from frictool.equations.notation import RATES, Notation, function, indexed_latex
from frictool.friction.law_registry import LAWS

SIGNS = {"low": r"\geq", "high": r"\leq"}  # relation of the effort of each end to 0


@dataclass(frozen=True)
class ElementEquations:
    """Equations of one element.

    - efforts: (block, effort in the block's positive direction)
    - curves: texts with the points of the curves
    - modes: conditions, such as contact or a limit of the drive
    - dry: (block, effort, largest magnitude at rest) for each friction that can stick; the effort
      is also in `efforts`
    """

    efforts: tuple[tuple[str, Term], ...] = ()
    equations: tuple[Equation, ...] = ()
    curves: tuple[Condition, ...] = ()
    modes: tuple[Condition, ...] = ()
    dry: tuple[tuple[str, Term, Term], ...] = ()


def spring(name: str, element: Spring, notation: Notation, start: float) -> ElementEquations:
    """Return the equations of a spring: F = k e + d e' + F0, or F = curve(e) + d e'.

    F acts on the second end, and -F on the first end. k is the stiffness, d the damping, F0 the
    preload, and e the stretch. The stretch is q_a - q_b minus the unstretched length: the key
    `free`, by default the value at the start. With a curve, e is q_a - q_b.

    start: q_a - q_b at the start [rad | m].
    """
    key = f"links.{name}"
    first, second = element.between
    kind = notation.kinds[first]
    stretch, rate = notation.stretch("e", name, kind)
    ends = [notation.position(first)] + (
        [] if second == GROUND else [notation.position(second).negative()]
    )
    terms: list[Term] = []
    curves: tuple[Condition, ...] = ()
    if element.stiffness is not None:
        terms.append(
            notation.parameter("k", "k", name, element.stiffness, f"{key}.stiffness").times(stretch)
        )
        if element.free is not None:
            ends.append(
                notation.parameter("free", "e_0", name, element.free, f"{key}.free").negative()
            )
        elif start:
            stood = notation.parameter(
                "free",
                "e_0",
                name,
                Quantity(abs(start), unit=RATES[kind][0]),
                f"blocks.{first}.start",
            )
            ends.append(stood.negative() if start > 0.0 else stood)
    if element.force is not None:
        value, stated = _curve(f"curve_{name}", name, "f", element.force, stretch, f"{key}.force")
        terms, curves = [*terms, value], (stated,)
    if element.damping is not None:
        terms.append(
            notation.parameter("d", "d", name, element.damping, f"{key}.damping").times(rate)
        )
    if element.preload is not None:
        terms.append(notation.parameter("F0", "F_0", name, element.preload, f"{key}.preload"))
    force = notation.effort("F", name, kind).of(key)
    unit = si_unit("effort", kind)
    equations = (
        Equation(
            (Term(),),
            stretch.factors[0][0],
            tuple(term.of(key) for term in ends),
            RATES[kind][0],
            key,
        ),
        Equation((Term(),), force.factors[0][0], tuple(term.of(key) for term in terms), unit, key),
    )
    efforts = [(first, force.negative())] + ([] if second == GROUND else [(second, force)])
    return ElementEquations(tuple(efforts), equations, curves)


def cam(name: str, element: Cam, notation: Notation) -> ElementEquations:
    """Return the equations of a cam: effort F(x) tan(alpha(x)) and friction mu F(x).

    - x: position
    - F: force of the spring
    - alpha: slope angle of the profile
    - mu: friction coefficient
    """
    key = f"links.{name}"
    block = element.on
    position = notation.position(block)
    force, force_curve = _curve(f"F_{name}", name, "F", element.force, position, f"{key}.force")
    alpha, angle_curve = _curve(
        f"alpha_{name}", name, r"\alpha", element.angle, position, f"{key}.angle"
    )
    steep = function("tan", r"\tan", alpha.text, alpha.latex)
    efforts = [(block, force.times(steep).of(key))]
    dry: tuple[tuple[str, Term, Term], ...] = ()
    if element.friction_coefficient > 0.0:
        mu = notation.number(
            "mu", r"\mu", name, element.friction_coefficient, f"{key}.friction_coefficient"
        )
        speed = notation.speed(block)
        pressed = mu.times(force).of(key)
        resists = pressed.times(
            function("sign", r"\mathrm{sign}", speed.text, speed.latex)
        ).negative()
        efforts.append((block, resists))
        ratio = notation.number(
            "beta", r"\beta", name, element.breakaway_ratio, f"{key}.breakaway_ratio"
        )
        dry = ((block, resists, ratio.times(pressed)),)
    return ElementEquations(
        tuple(efforts), (), (replace(force_curve, source="(2.23)"), angle_curve), (), dry
    )


def friction(name: str, element: FrictionOf, notation: Notation) -> ElementEquations:
    """Return the equations of a friction element: the effort -F on the block, and F by its law."""
    key = f"links.{name}"
    block = element.on
    kind = notation.kinds[block]
    force = notation.effort("F", name, kind).of(key)
    level = Term()
    curves: tuple[Condition, ...] = ()
    if element.level is not None:
        level, stated = _curve(
            f"level_{name}", name, r"\ell", element.level, notation.position(block), f"{key}.level"
        )
        curves = (stated,)
    terms = tuple(level.times(term).of(key) for term in friction_terms(name, element, notation))
    law = LAWS[element.law]
    equation = Equation(
        (Term(),),
        force.factors[0][0],
        terms,
        si_unit("effort", kind),
        key,
        f"{law.title}, in slip",
        law.equations,
    )
    bears = dry_level(name, element, notation)
    dry = () if bears is None else ((block, force.negative(), level.times(bears).of(key)),)
    return ElementEquations(((block, force.negative()),), (equation,), curves, (), dry)


def stop(name: str, element: Stop, notation: Notation) -> ElementEquations:
    """Return the equations of an end stop: its contact force N, and the conditions of contact.

    A compliant stop has N = -k s - d s'.

    - s: distance beyond the end
    - k: stiffness
    - d: damping
    """
    key = f"links.{name}"
    block = element.on
    kind = notation.kinds[block]
    position = notation.position(block)
    sides = [
        (
            side,
            notation.parameter(
                side,
                rf"{position.latex.partition('_')[0]}_\mathrm{{{side}}}",
                name,
                value,
                f"{key}.{side}",
            ),
        )
        for side, value in (("low", element.low), ("high", element.high))
        if value is not None
    ]
    force = notation.effort("N", name, kind).of(key)
    where = " and ".join(
        f"N_{name} {'>=' if side == 'low' else '<='} 0 at {position.text} = {end.text}"
        for side, end in sides
    )
    latex = r",\quad ".join(
        rf"{force.latex} {SIGNS[side]} 0 \;\text{{at}}\; {position.latex} = {end.latex}"
        for side, end in sides
    )
    unit = RATES[kind][0]
    terms = (position, *(end for _, end in sides))
    if element.compliance is None:
        shock = f"-{element.restitution:g} times itself" if element.restitution else "0"
        speed = notation.speed(block).text
        text = (
            f"{name} holds {block} back: {where}, else N_{name} = 0; "
            f"at an impact {speed} becomes {shock}"
        )
        return ElementEquations(
            ((block, force),), (), (), (Condition(text, latex, unit, terms, key),)
        )
    taut, rate = notation.stretch("s", name, kind)
    beyond = " and ".join(
        f"{taut.text} = {position.text} - {end.text} {'below' if side == 'low' else 'above'} "
        f"{end.text}"
        for side, end in sides
    )
    text = f"{name} pushes {block} back beyond its ends: {beyond}; an end cannot pull"
    stiff = (
        notation.parameter(
            "k", "k", name, element.compliance.stiffness, f"{key}.compliance.stiffness"
        )
        .times(taut)
        .negative()
    )
    drag = (
        notation.parameter("d", "d", name, element.compliance.damping, f"{key}.compliance.damping")
        .times(rate)
        .negative()
    )
    equation = Equation(
        (Term(),), force.factors[0][0], (stiff.of(key), drag.of(key)), si_unit("effort", kind), key
    )
    return ElementEquations(
        ((block, force),), (equation,), (), (Condition(text, latex, unit, (taut, *terms), key),)
    )


def source(name: str, element: Source, notation: Notation) -> ElementEquations:
    """Return the equations of a source.

    The effort of the source is the input u, or a constant times the input current or voltage. If
    the document states a constant effort u0, u0 is added.
    """
    key = f"sources.{name}"
    block = element.on
    kind = notation.kinds[block]
    efforts: list[tuple[str, Term]] = []
    if element.effort is not None:
        efforts.append(
            (block, notation.parameter("u0", "u_0", name, element.effort, f"{key}.effort"))
        )
    letter, unit = {
        "current": ("i", "A"),
        "voltage": ("U", "V"),
        "effort": ("u", si_unit("effort", kind)),
    }[element.drive]
    drive = symbol(f"{letter}_{name}", indexed_latex(letter, name), unit)
    driven = (
        drive
        if element.constant is None
        else notation.parameter("K", "K", name, element.constant, f"{key}.constant").times(drive)
    )
    efforts.append((block, driven.of(key)))
    equations: list[Equation] = []
    modes: list[Condition] = []
    if element.loop_time_constant_s:
        constant = Quantity(element.loop_time_constant_s, unit="s")
        lag = notation.parameter("T", "T", name, constant, f"{key}.loop_time_constant_s")
        rate = Atom(f"{drive.text}'", indexed_latex(rf"\dot{{{letter}}}", name), f"{unit}/s")
        command = symbol(f"command_{name}", indexed_latex(f"{letter}^*", name), unit)
        equations.append(
            Equation((lag,), rate, (command.of(key), drive.negative().of(key)), unit, key)
        )
    if element.limit is not None:
        most = notation.parameter("max", rf"{letter}_\max", name, element.limit, f"{key}.limit")
        modes.append(
            Condition(
                f"{name} is limited: |command_{name}| <= {most.text}",
                rf"\left|{drive.latex}\right| \leq {most.latex}",
                unit,
                (drive, most),
                key,
            )
        )
    if element.winding is not None and element.constant is not None:
        modes.append(_winding(name, element, notation, drive))
    return ElementEquations(tuple(efforts), tuple(equations), (), tuple(modes))


def _winding(name: str, element: Source, notation: Notation, drive: Term) -> Condition:
    key = f"sources.{name}.winding"
    assert element.winding is not None
    assert element.constant is not None
    ohms = Quantity(element.winding.resistance_ohm, unit="ohm")
    resistance = (
        notation.parameter("R", "R", name, ohms, f"{key}.resistance_ohm").times(drive).of(key)
    )
    back = (
        notation.parameter("K", "K", name, element.constant, f"sources.{name}.constant")
        .times(notation.speed(element.on))
        .of(key)
    )
    supply = notation.parameter(
        "U", "U", name, Quantity(element.winding.voltage_v, unit="V"), f"{key}.voltage_v"
    ).of(key)
    voltage = f"|{resistance.text} + {back.text}|"
    text = f"the supply limits the voltage of {name}: {voltage} <= {supply.text}"
    return Condition(
        text,
        rf"\left|{resistance.latex} + {back.latex}\right| \leq {supply.latex}",
        "V",
        (resistance, back, supply),
        key,
    )


def _curve(
    text: str, name: str, letter: str, curve: Curve | Level, at: Term, key: str
) -> tuple[Term, Condition]:
    values, unit = (
        (curve.factor, "") if isinstance(curve, Level) else (curve.value.values, curve.value.unit)
    )
    points = curve.position.values
    value = function(text, indexed_latex(letter, name), at.text, at.latex, unit).of(key)
    said = (
        f"{value.text}: {len(points)} points from {points[0]:g} to {points[-1]:g} "
        f"{curve.position.unit}, "
        f"{min(values):g} to {max(values):g} {unit}".rstrip()
    )
    argument = symbol(at.text, at.latex, curve.position.unit)
    return value, Condition(said, value.latex, curve.position.unit, (at, argument), key)
