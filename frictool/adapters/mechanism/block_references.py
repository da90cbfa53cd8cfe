"""References of elements to blocks: names, kinds of motion, and units."""

from __future__ import annotations

import difflib
import re

from frictool.documents.mechanism import GROUND, Block, Compliance, Mechanism
from frictool.documents.quantity import Axis, Quantity, Series, Span, si_unit
from frictool.plant.mechanism.element_error import ElementError

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
MOTION = {"rotary": "turns", "linear": "slides"}


def axis_kind(block: Block) -> Axis:
    """Return the motion of a block, "rotary" or "linear"."""
    return "rotary" if block.inertia is not None else "linear"


class BlockNames:
    """The blocks of a mechanism by name, in the document's order."""

    def __init__(self, document: Mechanism) -> None:
        """Read the blocks; raise ElementError for a name that is not allowed."""
        if not document.blocks:
            raise ElementError(
                "blocks", "found none; allowed: at least one, with its inertia or mass"
            )
        for group in ("blocks", "links", "sources", "sensors"):
            for name in getattr(document, group):
                _check_name(f"{group}.{name}", name)
        self.names = tuple(document.blocks)
        self.kinds = tuple(axis_kind(block) for block in document.blocks.values())

    def index(self, key: str, name: str) -> int:
        """Return the index of the block called `name`.

        `key`: key of the element that refers to the block, for errors.

        Raises ElementError if no block has this name, or if `name` is the frame.
        """
        if name == GROUND:
            raise ElementError(
                key,
                f"found {GROUND}, which does not move; allowed: the blocks {', '.join(self.names)}",
            )
        if name in self.names:
            return self.names.index(name)
        near = difflib.get_close_matches(name, [*self.names, GROUND], n=1, cutoff=0.5)
        hint = f", did you mean {near[0]!r}?" if near else ""
        raise ElementError(
            key,
            f"found {name!r}, which is not a block{hint}; allowed: {', '.join(self.names)}, and "
            f"{GROUND}, the frame",
        )

    def kind(self, key: str, name: str) -> Axis:
        """Return the motion of the block called `name`, rotary or linear."""
        return self.kinds[self.index(key, name)]

    def two(self, key: str, between: tuple[str, ...]) -> tuple[str, str]:
        """Return both ends of an element: first a block, then a block or the frame.

        Raises ElementError if an end is missing or unknown, or if both ends are the same.
        """
        where = f"{key}.between"
        if len(between) < 2:
            raise ElementError(
                where,
                f"found one end, [{between[0]}]; allowed: two; the frame is an end too: "
                f"[{between[0]}, {GROUND}]",
            )
        first, second = between
        if first == second:
            raise ElementError(where, f"found both ends on {first}; allowed: two different ends")
        if first == GROUND:
            raise ElementError(
                where,
                f"found {GROUND} as the first end; allowed: a block first, [{second}, {GROUND}]",
            )
        self.index(where, first)
        if second != GROUND:
            self.index(where, second)
        return first, second

    def moving(self, key: str, between: tuple[str, ...], hint: str) -> tuple[str, str]:
        """Return both ends of an element that links two blocks.

        `hint`: advice in the error if an end is the frame.

        Raises ElementError if an end is missing, unknown or the frame, or if both ends are the
        same.
        """
        where = f"{key}.between"
        if GROUND in between:
            other = next((name for name in between if name != GROUND), between[0])
            raise ElementError(
                where,
                (f"found {GROUND} as an end, which would fix {other}; allowed: two blocks; {hint}"),
            )
        return self.two(key, between)

    def sequence(
        self, key: str, what: str, ends: tuple[str, str], kinds: tuple[Axis, Axis]
    ) -> None:
        """Raise ElementError if the ends do not move as `kinds` (rotary or linear, in order)."""
        where = f"{key}.between"
        motions = (self.kind(where, ends[0]), self.kind(where, ends[1]))
        if motions == kinds:
            return
        described = " and ".join(
            f"{name}, which {MOTION[kind]}" for name, kind in zip(ends, motions, strict=True)
        )
        required = " and one that ".join(MOTION[kind] for kind in kinds)
        turned = motions == kinds[::-1] and kinds[0] != kinds[1]
        hint = (
            f"; write [{ends[1]}, {ends[0]}]"
            if turned
            else "; a rack or screw links a rotary block to a linear block"
        )
        raise ElementError(
            where, f"found {described}; allowed for {what}: a block that {required}{hint}"
        )


def check_unit(
    key: str, quantity: Quantity | Series | Span | None, dimension: str, kind: Axis, whose: str
) -> None:
    """Raise ElementError if the unit of a quantity does not have the dimension `dimension`.

    `kind`: motion of the block, which decides between units such as N m and N.
    `whose`: name of the element that has the quantity, for the error.
    """
    wanted = si_unit(dimension, kind)
    if quantity is not None and quantity.unit != wanted:
        hint = f"{whose} {MOTION[kind]}" if whose else f"the block {MOTION[kind]}"
        raise ElementError(
            f"{key}.unit",
            f"found a multiple of {quantity.unit}; allowed: {wanted} and its multiples, since "
            f"{hint}",
        )


def check_compliance(key: str, compliance: Compliance | None, kind: Axis, whose: str) -> None:
    """Raise ElementError if stiffness or damping do not have the units of the motion `kind`."""
    if compliance is not None:
        check_unit(f"{key}.stiffness", compliance.stiffness, "stiffness", kind, whose)
        check_unit(f"{key}.damping", compliance.damping, "viscous", kind, whose)


def _check_name(key: str, name: str) -> None:
    if name == GROUND:
        raise ElementError(
            key, f"{GROUND} is the frame, which needs no entry; allowed: another name"
        )
    if not NAME.fullmatch(name):
        raise ElementError(
            key, f"found the name {name!r}; allowed: a letter, then letters, digits and _"
        )
