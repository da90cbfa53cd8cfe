"""Equations of transmitting links: constraints, compliance and backlash (thesis 2.3-2.20)."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.adapters.mechanism.transmissions import Transmitting
from frictool.documents.mechanism import Backlash
from frictool.documents.quantity import Quantity, si_unit
from frictool.equations.condition import Condition
from frictool.equations.expression import Equation, Term
from frictool.equations.link_ratios import EffortTransfer, effort_transfer, ratio_of
from frictool.equations.notation import HALF, RATES, Notation, indexed_latex

SOURCES = {
    "gear": "(2.3)",
    "belt": "(2.6)",
    "screw": "(2.10)-(2.13)",
    "rack": "(2.19)",
    "hydraulic": "(2.16)",
    "coupling": "",
}
LAMBDA = r"\lambda"
SOFT_SOURCES = {"gear": "(2.5)", "belt": "(2.6)"}


@dataclass(frozen=True)
class LinkEquations:
    """Equations of one link.

    The link connects the blocks a (first end) and b (second end).

    - force: effort lambda on the block b
    - passed: transfer of lambda to the block a
    - rigid: True if the link is a constraint; a link with backlash is a constraint only while a
      flank touches
    - play: half of the backlash at b [rad | m]
    - relations: equations of positions and speeds
    - effort: equations of lambda
    - modes: conditions of free motion and contact in the backlash
    """

    name: str
    a: str
    b: str
    ratio: Term
    force: Term
    passed: EffortTransfer
    rigid: bool
    play: Term | None
    relations: tuple[Equation, ...]
    effort: tuple[Equation, ...]
    modes: tuple[Condition, ...]

    def on_first(self) -> list[Term]:
        """Return the efforts of the link on the block a."""
        key = f"links.{self.name}"
        back = self.passed.factor.times(self.force).negative().of(key)
        return (
            [back]
            if self.passed.additional is None
            else [back, self.passed.additional.negative().of(key)]
        )


def link_equations(
    name: str, link: Transmitting, notation: Notation, offset: float
) -> LinkEquations:
    """Return the equations of a link between blocks with the positions q_a and q_b.

    offset: q_b - ratio q_a at the start [rad | m].
    """
    a, b = link.between
    key = f"links.{name}"
    ratio, along = ratio_of(name, link, notation)
    force = notation.effort("lambda", name, notation.kinds[b]).of(key)
    backlash: Backlash | None = getattr(link, "backlash", None)
    play = None if backlash is None else _half_width(name, link, backlash, notation, ratio)
    compliance = link.compliance or (None if backlash is None else backlash.compliance)
    rigid = compliance is None
    relations = _relations(name, link, notation, ratio, offset, rigid and play is None)
    effort = () if rigid else _yielding(name, link, notation, along, force, play is not None)
    modes: tuple[Condition, ...] = ()
    if backlash is not None and play is not None:
        modes = (
            _within(name, b, notation, play),
            _rebounding(name, link, notation, ratio, play, backlash.restitution)
            if rigid
            else _pressed(name, b, notation, play),
        )
    return LinkEquations(
        name,
        a,
        b,
        ratio,
        force,
        effort_transfer(name, link, notation, ratio, force),
        rigid,
        play,
        relations,
        effort,
        modes,
    )


def _relations(
    name: str, link: Transmitting, notation: Notation, ratio: Term, offset: float, constrains: bool
) -> tuple[Equation, ...]:
    """Return the constraint q_b = ratio q_a + o of a rigid link without backlash.

    For a link with backlash or compliance, return the definition e = q_b - ratio q_a - o of the
    stretch e. o is the offset.
    """
    a, b = link.between
    key = f"links.{name}"
    source = SOURCES[str(link.__struct_config__.tag)]
    position, rate, _ = RATES[notation.kinds[b]]
    follows = [ratio.times(notation.position(a)).of(key)]
    if offset:
        kept = notation.parameter(
            "o", "o", name, Quantity(abs(offset), unit=position), f"blocks.{b}.start"
        )
        follows.append(kept if offset > 0.0 else kept.negative())
    if constrains:
        return (
            Equation(
                (Term(),),
                notation.position(b).factors[0][0],
                tuple(follows),
                position,
                key,
                source=source,
            ),
            Equation(
                (Term(),),
                notation.speed(b).factors[0][0],
                (ratio.times(notation.speed(a)).of(key),),
                rate,
                key,
                source=source,
            ),
        )
    stretch, _ = notation.stretch("e", name, notation.kinds[b])
    terms = (notation.position(b).of(key), *(term.negative() for term in follows))
    return (Equation((Term(),), stretch.factors[0][0], terms, position, key, source=source),)


def _yielding(
    name: str, link: Transmitting, notation: Notation, along: Term, force: Term, plays: bool
) -> tuple[Equation, ...]:
    """Return the equation lambda = -k e - d e' of the effort at a compliant link's second end.

    - e: deformation of the link; for a link with backlash, its symbol is s
    - k: stiffness
    - d: damping

    For a belt, k and d are along the belt, at the pulley radius r_b.
    """
    backlash: Backlash | None = getattr(link, "backlash", None)
    compliance = link.compliance or (backlash.compliance if backlash is not None else None)
    assert compliance is not None
    where = f"links.{name}." + (
        "compliance" if link.compliance is not None else "backlash.compliance"
    )
    kind = notation.kinds[link.between[1]]
    stretch, rate = notation.stretch("s" if plays else "e", name, kind)
    stiff = notation.parameter("k", "k", name, compliance.stiffness, f"{where}.stiffness").times(
        stretch
    )
    drag = notation.parameter("d", "d", name, compliance.damping, f"{where}.damping").times(rate)
    terms = tuple(
        along.times(along).times(part).negative().of(f"{where}.{what}")
        for part, what in ((stiff, "stiffness"), (drag, "damping"))
    )
    source = SOFT_SOURCES.get(str(link.__struct_config__.tag), "")
    return (
        Equation(
            (Term(),),
            force.factors[0][0],
            terms,
            si_unit("effort", kind),
            f"links.{name}",
            source=source,
        ),
    )


def _half_width(
    name: str, link: Transmitting, backlash: Backlash, notation: Notation, ratio: Term
) -> Term:
    key = f"links.{name}.backlash.width"
    width = notation.parameter("w", "w", name, backlash.width, key)
    a, b = link.between
    at = backlash.at or (b if RATES[notation.kinds[b]][0] == backlash.width.unit else a)
    return (Term() if at == b else Term(ratio.factors)).times(width).times(HALF).of(key)


def _within(name: str, b: str, notation: Notation, play: Term) -> Condition:
    stretch, _ = notation.stretch("e", name, notation.kinds[b])
    text = f"{name} is open while |{stretch.text}| < {play.text}: lambda_{name} = 0"
    latex = rf"\left|{stretch.latex}\right| < {play.latex}: \quad {indexed_latex(LAMBDA, name)} = 0"
    return Condition(
        text, latex, RATES[notation.kinds[b]][0], (stretch, play), f"links.{name}", "(2.18)"
    )


def _pressed(name: str, b: str, notation: Notation, play: Term) -> Condition:
    stretch, _ = notation.stretch("e", name, notation.kinds[b])
    taut, _ = notation.stretch("s", name, notation.kinds[b])
    ends = f"{taut.text} = {stretch.text} - {play.text} above, {stretch.text} + {play.text} below"
    return Condition(
        f"{name} touches outside: {ends}, lambda_{name} {taut.text} <= 0 (no flank pulls)",
        rf"{taut.latex} = {stretch.latex} \mp {play.latex}",
        RATES[notation.kinds[b]][0],
        (taut, stretch, play),
        f"links.{name}",
    )


def _rebounding(
    name: str, link: Transmitting, notation: Notation, ratio: Term, play: Term, restitution: float
) -> Condition:
    a, b = link.between
    stretch, _ = notation.stretch("e", name, notation.kinds[b])
    follows = ratio.times(notation.speed(a)).negative()
    sign = "-" if follows.sign < 0 else "+"
    slip = f"{notation.speed(b).text} {sign} {follows.text}"
    slip_latex = f"{notation.speed(b).latex} {sign} {follows.latex}"
    after = f"-{restitution:g} times itself" if restitution else "0"
    ends = (
        f"{stretch.text} = -{play.text} with lambda_{name} >= 0, "
        f"at {stretch.text} = {play.text} with lambda_{name} <= 0"
    )
    text = f"{name} touches at {ends}: {slip} = 0, and at an impact becomes {after}"
    return Condition(
        text,
        rf"{stretch.latex} = \mp {play.latex}: \quad {slip_latex} = 0",
        RATES[notation.kinds[b]][0],
        (stretch, play),
        f"links.{name}",
        "(2.19)",
    )
