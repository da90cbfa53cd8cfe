"""Free bodies (2.1)-(2.2), and the constraint forces eliminated: one equation for all that moves as one.

From a leaf of the tree of rigid links to its root: with the child's M q'' = f, a link to its second end gives lambda = M q'' - f there and
takes p lambda at its first, so that the first end's inertia grows by p ratio M and its efforts by p f; the other way by M/(p ratio), f/p.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from frictool.documents.quantity import si_unit
from frictool.plant.mechanism.equations.expression import Atom, Equation, Term, summed, summed_latex
from frictool.plant.mechanism.equations.notation import Notation
from frictool.plant.mechanism.equations.statement import Statement
from frictool.plant.mechanism.equations.transmitting import Drawn

Efforts = Mapping[str, Sequence[Term]]


def free_body(block: str, efforts: Efforts, links: Sequence[Drawn], notation: Notation) -> Equation:
    """m q'' = sum of what acts on the block, forces of rigid links among it."""
    right = [*efforts[block]]
    for link in links:
        if link.b == block:
            right.append(link.force)
        if link.a == block:
            right += link.on_first()
    unit = si_unit("effort", notation.kinds[block])
    return Equation((notation.inertia(block),), notation.acceleration(block), tuple(right), unit, f"blocks.{block}", source="(2.1)")


class Tree:
    """Blocks tied by rigid links without play, `links`, seen from `root`."""

    def __init__(self, root: str, links: Sequence[Drawn], notation: Notation) -> None:
        self.root, self.links, self.notation = root, links, notation

    def equation(self, efforts: Efforts) -> Equation:
        """(sum of inertias) q_root'' = sum of efforts."""
        inertia = self._lumped(self.root, None)
        right = self._gathered(self.root, None, efforts, beside=True)
        unit = si_unit("effort", self.notation.kinds[self.root])
        return Equation(tuple(inertia), self.notation.acceleration(self.root), tuple(right), unit, f"blocks.{self.root}")

    def gathered(self, efforts: Efforts) -> list[Term]:
        """Efforts on its blocks as the root feels them."""
        return self._gathered(self.root, None, efforts, beside=False)

    def _children(self, block: str, above: Drawn | None) -> list[Drawn]:
        return [link for link in self.links if link is not above and block in (link.a, link.b)]

    def _lumped(self, block: str, above: Drawn | None) -> list[Term]:
        out = [self.notation.inertia(block)]
        for link in self._children(block, above):
            child = link.b if link.a == block else link.a
            seen = link.passed.factor.times(link.ratio)
            seen = seen if link.a == block else seen.inverse()
            out += [seen.times(term) for term in self._lumped(child, link)]
        return out

    def _gathered(self, block: str, above: Drawn | None, efforts: Efforts, beside: bool) -> list[Term]:
        out = list(efforts.get(block, ()))
        if beside:
            out += [link.passed.beside.negative() for link in self.links if link.a == block and link.passed.beside is not None]
        for link in self._children(block, above):
            child = link.b if link.a == block else link.a
            seen = link.passed.factor if link.a == block else link.passed.factor.inverse()
            out += [seen.times(term) for term in self._gathered(child, link, efforts, beside)]
        return out


def holds(tree: Tree, blocks: Sequence[str], efforts: Efforts, dry: Efforts, bears: Efforts, notation: Notation) -> Statement | None:
    """While its efforts without dry friction are within what frictions and lossy links bear, a tree stays at rest; None: nothing sticks.

    At rest a lossy link passes anything between its two p.
    """
    threads = {link.a: _modulus(link.passed.beside) for link in tree.links if link.passed.beside is not None}
    between = [link.passed.factor.text for link in tree.links if link.passed.equations and link.passed.beside is None]
    borne = {block: [*bears.get(block, ()), *([threads[block]] if block in threads else [])] for block in blocks}
    most = [_modulus(term) for term in tree.gathered(borne)]
    if not most and not between:
        return None
    others = {block: [term for term in efforts[block] if term not in dry.get(block, ())] for block in blocks}
    pushing = tree.gathered(others)
    bounds, bounds_latex = " + ".join(term.text for term in most), " + ".join(term.latex for term in most)
    text = f"|{summed(pushing)}| <= {bounds}" if most else f"{summed(pushing)} = 0"
    latex = rf"\left|{summed_latex(pushing)}\right| \leq {bounds_latex}" if most else rf"{summed_latex(pushing)} = 0"
    some = f" for some {' and '.join(between)} between what it is in both directions of power" if between else ""
    told = f"{', '.join(blocks)} at rest {'stays' if len(blocks) == 1 else 'stay'} while {text}{some}"
    return Statement(told, latex, si_unit("effort", notation.kinds[tree.root]), (*pushing, *most), f"blocks.{tree.root}", "(2.30)")


def _modulus(term: Term) -> Term:
    """Its size: without the sign, and with |p| and |W| for what may be negative."""

    def sized(atom: Atom) -> Atom:
        signed = atom.text.startswith(("p_", "W_"))
        return Atom(f"|{atom.text}|", rf"\left|{atom.latex}\right|", atom.unit, None, atom.made) if signed else atom

    return Term(tuple((sized(atom), power) for atom, power in term.factors), 1, term.element)
