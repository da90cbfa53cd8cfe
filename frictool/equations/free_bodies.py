"""Equations of free bodies (thesis 2.1-2.2), and of trees of rigid links without constraint forces.

The constraint forces lambda are eliminated from the leaves of a tree to its root. Let a child with
the inertia M and the effort f be at the second end b of a link, with q_b = ratio q_a. The link acts
on the child with lambda = M q_b'' - f, and on the first end a with -p lambda (link_ratios.py).
Therefore p ratio M is added to the inertia at a, and p f to the effort at a. If the child is at the
first end a, M/(p ratio) is added to the inertia at b, and f/p to the effort at b.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from frictool.documents.quantity import si_unit
from frictool.equations.condition import Condition
from frictool.equations.expression import Atom, Equation, Term, sum_latex, sum_text
from frictool.equations.link_equations import LinkEquations
from frictool.equations.notation import Notation

Efforts = Mapping[str, Sequence[Term]]


def free_body(
    block: str, efforts: Efforts, links: Sequence[LinkEquations], notation: Notation
) -> Equation:
    """Return the equation m q'' = sum of all efforts on a block, with the forces of rigid links."""
    right = [*efforts[block]]
    for link in links:
        if link.b == block:
            right.append(link.force)
        if link.a == block:
            right += link.on_first()
    unit = si_unit("effort", notation.kinds[block])
    return Equation(
        (notation.inertia(block),),
        notation.acceleration(block),
        tuple(right),
        unit,
        f"blocks.{block}",
        source="(2.1)",
    )


class RigidTree:
    """Tree of blocks that rigid `links` connect; `root` is the root block."""

    def __init__(self, root: str, links: Sequence[LinkEquations], notation: Notation) -> None:
        self.root, self.links, self.notation = root, links, notation

    def equation(self, efforts: Efforts) -> Equation:
        """Return the equation of the tree, with all inertias and efforts reflected to the root.

        The equation is (sum of inertias) q_root'' = sum of efforts.
        """
        inertia = [mass.times(self.notation.inertia(block)) for block, _, mass in self._walk()]
        right = self._gathered(efforts, extra=True)
        unit = si_unit("effort", self.notation.kinds[self.root])
        return Equation(
            tuple(inertia),
            self.notation.acceleration(self.root),
            tuple(right),
            unit,
            f"blocks.{self.root}",
        )

    def gathered(self, efforts: Efforts) -> list[Term]:
        """Return the efforts on all blocks of the tree, reflected to the root."""
        return self._gathered(efforts, extra=False)

    def _walk(self) -> Iterator[tuple[str, Term, Term]]:
        at: dict[str, list[LinkEquations]] = {}
        for link in self.links:
            at.setdefault(link.a, []).append(link)
            at.setdefault(link.b, []).append(link)
        waiting: list[tuple[str, LinkEquations | None, Term, Term]] = [
            (self.root, None, Term(), Term())
        ]
        while waiting:
            block, above, effort, mass = waiting.pop()
            yield block, effort, mass
            for link in reversed([one for one in at.get(block, ()) if one is not above]):
                first = link.a == block
                passed = link.passed.factor
                moved = link.passed.factor.times(link.ratio)
                through, carried = (passed, moved) if first else (passed.inverse(), moved.inverse())
                waiting.append(
                    (link.b if first else link.a, link, effort.times(through), mass.times(carried))
                )

    def _gathered(self, efforts: Efforts, extra: bool) -> list[Term]:
        out: list[Term] = []
        for block, effort, _ in self._walk():
            out += [effort.times(term) for term in efforts.get(block, ())]
            if extra:
                threads = [
                    link.passed.additional
                    for link in self.links
                    if link.a == block and link.passed.additional is not None
                ]
                out += [effort.times(thread.negative()) for thread in threads]
        return out


def rest_condition(
    tree: RigidTree,
    blocks: Sequence[str],
    efforts: Efforts,
    dry: Efforts,
    bears: Efforts,
    notation: Notation,
) -> Condition | None:
    """Return the condition for a tree to stay at rest; None if the tree has no dry friction.

    Dry friction must be able to balance the tree's other efforts. At rest, the factor p by which a
    lossy link transfers effort may lie anywhere between its values for the two directions of power.

    - efforts: all efforts on each block
    - dry: dry friction on each block, which is part of `efforts`
    - bears: largest dry friction at rest on each block
    """
    threads = {
        link.a: _modulus(link.passed.additional)
        for link in tree.links
        if link.passed.additional is not None
    }
    between = [
        link.passed.factor.text
        for link in tree.links
        if link.passed.equations and link.passed.additional is None
    ]
    borne = {
        block: [*bears.get(block, ()), *([threads[block]] if block in threads else [])]
        for block in blocks
    }
    most = [_modulus(term) for term in tree.gathered(borne)]
    if not most and not between:
        return None
    others = {
        block: [term for term in efforts[block] if term not in dry.get(block, ())]
        for block in blocks
    }
    pushing = tree.gathered(others)
    bounds, bounds_latex = (
        " + ".join(term.text for term in most),
        " + ".join(term.latex for term in most),
    )
    text = f"|{sum_text(pushing)}| <= {bounds}" if most else f"{sum_text(pushing)} = 0"
    latex = (
        rf"\left|{sum_latex(pushing)}\right| \leq {bounds_latex}"
        if most
        else rf"{sum_latex(pushing)} = 0"
    )
    some = (
        f" for some {' and '.join(between)} between its values in both directions of power"
        if between
        else ""
    )
    sentence = (
        f"{', '.join(blocks)} {'stays' if len(blocks) == 1 else 'stay'} at rest while {text}{some}"
    )
    return Condition(
        sentence,
        latex,
        si_unit("effort", notation.kinds[tree.root]),
        (*pushing, *most),
        f"blocks.{tree.root}",
        "(2.30)",
    )


def _modulus(term: Term) -> Term:
    def sized(atom: Atom) -> Atom:
        signed = atom.text.startswith(("p_", "W_"))
        return (
            Atom(f"|{atom.text}|", rf"\left|{atom.latex}\right|", atom.unit, None, atom.made)
            if signed
            else atom
        )

    return Term(tuple((sized(atom), power) for atom, power in term.factors), 1, term.element)
