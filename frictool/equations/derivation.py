"""Derivation of a mechanism's equations from its description."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from frictool.adapters.mechanism.transmissions import Transmitting
from frictool.documents.mechanism import GROUND, Cam, FrictionOf, Mechanism, Spring, Stop
from frictool.equations.condition import Condition
from frictool.equations.dimension_check import check_equation, check_sum
from frictool.equations.element_equations import (
    ElementEquations,
    cam,
    friction,
    source,
    spring,
    stop,
)
from frictool.equations.expression import Equation, Term
from frictool.equations.free_bodies import RigidTree, free_body, rest_condition
from frictool.equations.link_equations import LinkEquations, link_equations
from frictool.equations.notation import Notation, ParameterRow
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism

Line = Equation | Condition
ROUNDING = 1e-12  # relative tolerance of products of ratios, tooth numbers and angles


@dataclass(frozen=True)
class Derivation:
    """Derived equations of a mechanism.

    - sections: (title, lines) of each section
    - checked: number of terms whose dimension was checked
    - directions: for each link with losses, a sentence that states whether its second end can drive
      its first end
    - notes: a line for each omission or assumption
    """

    name: str
    sections: tuple[tuple[str, tuple[Line, ...]], ...]
    parameters: tuple[ParameterRow, ...]
    directions: tuple[str, ...]
    notes: tuple[str, ...]
    checked: int


def derive(document: Mechanism, assembled: AssembledMechanism) -> Derivation:
    """Derive the equations; raise ElementError if the terms of a sum differ in dimension."""
    notation = Notation(document)
    start = dict(zip(assembled.blocks, assembled.start.tolist(), strict=True))
    links = _links(document, assembled, notation, start)
    acting = _acting(document, notation, start)
    rigid = [link for link in links if link.rigid and link.play is None]
    efforts: dict[str, list[Term]] = {block: [] for block in assembled.blocks}
    for one in acting:
        for block, term in one.efforts:
            efforts[block].append(term)
    for link in links:
        if link not in rigid:
            efforts[link.b].append(link.force)
            efforts[link.a] += link.on_first()
    bodies = [free_body(block, efforts, rigid, notation) for block in assembled.blocks]
    trees, modes = _trees(document, assembled, rigid, efforts, acting, notation)
    touching = [link for link in links if link.rigid]
    block_efforts = {
        block: [term for one in acting for on, term in one.efforts if on == block]
        for block in assembled.blocks
    }
    soft = [link for link in links if not link.rigid]
    for link in soft:
        block_efforts[link.b].append(link.force)
        block_efforts[link.a] += link.on_first()
    alone = {tree.text for tree in trees}
    closed = [
        tree
        for tree in _trees(document, assembled, touching, block_efforts, acting, notation)[0]
        if tree.text not in alone
    ]
    sections: list[tuple[str, tuple[Line, ...]]] = [
        (
            "Links",
            tuple(
                equation for link in links for equation in (*link.relations, *link.passed.equations)
            ),
        ),
        (
            "Efforts",
            (
                *(e for link in links for e in link.effort),
                *(e for one in acting for e in one.equations),
            ),
        ),
        ("Curves", tuple(curve for one in acting for curve in one.curves)),
        ("Free bodies", tuple(bodies)),
        ("Forces of rigid links eliminated", tuple(trees)),
        ("Forces of rigid links eliminated, every backlash closed", tuple(closed)),
        (
            "Modes",
            (
                *(m for link in links for m in link.modes),
                *(m for one in acting for m in one.modes),
                *modes,
            ),
        ),
    ]
    sections = [(title, lines) for title, lines in sections if lines]
    checked = sum(_checked(line) for _, lines in sections for line in lines)
    directions = tuple(link.passed.reason for link in links if link.passed.reason)
    return Derivation(
        document.name,
        tuple(sections),
        tuple(notation.parameters.values()),
        directions,
        assembled.notes,
        checked,
    )


def _checked(line: Line) -> int:
    return (
        check_equation(line)
        if isinstance(line, Equation)
        else check_sum(list(line.terms), line.unit)
    )


def _links(
    document: Mechanism, assembled: AssembledMechanism, notation: Notation, start: dict[str, float]
) -> list[LinkEquations]:
    ratios = {
        name: float(ratio)
        for name, ratio in zip(assembled.joints, assembled.packed.joints.ratio, strict=True)
    }
    ratios |= {
        name: float(ratio)
        for name, ratio in zip(assembled.couplings, assembled.packed.couplings.ratio, strict=True)
    }
    out = []
    for name, link in document.links.items():
        if isinstance(link, get_args(Transmitting)) and name in ratios:
            a, b = link.between
            out.append(
                link_equations(name, link, notation, _difference(start[b], ratios[name] * start[a]))
            )
    return out


def _acting(
    document: Mechanism, notation: Notation, start: dict[str, float]
) -> list[ElementEquations]:
    out = [source(name, element, notation) for name, element in document.sources.items()]
    for name, element in document.links.items():
        match element:
            case Spring():
                first, second = element.between
                out.append(
                    spring(
                        name,
                        element,
                        notation,
                        _difference(start[first], 0.0 if second == GROUND else start[second]),
                    )
                )
            case Cam():
                out.append(cam(name, element, notation))
            case FrictionOf():
                out.append(friction(name, element, notation))
            case Stop():
                out.append(stop(name, element, notation))
    return out


def _difference(one: float, other: float) -> float:
    difference = one - other
    return difference if abs(difference) > ROUNDING * max(abs(one), abs(other)) else 0.0


def _trees(
    document: Mechanism,
    assembled: AssembledMechanism,
    rigid: list[LinkEquations],
    efforts: dict[str, list[Term]],
    acting: list[ElementEquations],
    notation: Notation,
) -> tuple[list[Equation], list[Condition]]:
    driven = [element.on for element in document.sources.values()]
    dry: dict[str, list[Term]] = {}
    bears: dict[str, list[Term]] = {}
    for one in acting:
        for block, resists, most in one.dry:
            dry.setdefault(block, []).append(resists)
            bears.setdefault(block, []).append(most)
    equations, modes = [], []
    for names in _tied(assembled.blocks, rigid):
        root = next((block for block in driven if block in names), names[0])
        tree = RigidTree(root, [link for link in rigid if link.a in names], notation)
        if len(names) > 1:
            equations.append(tree.equation(efforts))
        if (stays := rest_condition(tree, names, efforts, dry, bears, notation)) is not None:
            modes.append(stays)
    return equations, modes


def _tied(blocks: tuple[str, ...], links: list[LinkEquations]) -> list[list[str]]:
    group = {block: [block] for block in blocks}
    for link in links:
        kept, joined = sorted((group[link.a], group[link.b]), key=len, reverse=True)
        if kept is not joined:
            kept += joined
            group.update(dict.fromkeys(joined, kept))
    first: dict[int, list[str]] = {}
    for block in blocks:
        first.setdefault(id(group[block]), []).append(block)
    return list(first.values())
