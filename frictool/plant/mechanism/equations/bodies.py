"""Free bodies (2.1)-(2.2), and the constraint forces eliminated: one equation for all that moves as one.

From a leaf of the tree of rigid links to its root: with the child's M q'' = f, a link to its second end gives lambda = M q'' - f there and
takes p lambda at its first, so that the first end's inertia grows by p ratio M and its efforts by p f; the other way by M/(p ratio), f/p.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from frictool.documents.quantity import si_unit
from frictool.plant.mechanism.equations.expression import Equation, Term, summed, summed_latex
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
    """While its efforts without dry friction are within what the frictions bear, a tree stays at rest; None where nothing sticks."""
    most = tree.gathered(bears)
    if not most:
        return None
    others = {block: [term for term in efforts[block] if term not in dry.get(block, ())] for block in blocks}
    pushing = tree.gathered(others)
    pressed = " + ".join(term.text for term in most)
    pushed = summed(pushing)
    told = ", ".join(blocks)
    between = " and ".join(link.passed.factor.text for link in tree.links if link.passed.equations and link.passed.beside is None)
    slack = f", with {between} anywhere between what they are in both directions of power" if between else ""
    if any(link.passed.beside is not None for link in tree.links):
        slack += ", and what the thread bears beside"
    text = f"{told} at rest {'stays' if len(blocks) == 1 else 'stay'} while |{pushed}| <= {pressed}{slack}"
    latex = rf"\left|{summed_latex(pushing)}\right| \leq {' + '.join(term.latex for term in most)}"
    return Statement(text, latex, si_unit("effort", notation.kinds[tree.root]), (*pushing, *most), f"blocks.{tree.root}", "(2.30)")
