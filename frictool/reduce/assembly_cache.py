"""Mechanisms put together once: the steps of a reduction ask for the same one again and again."""

from __future__ import annotations

from frictool.documents.mechanism import Mechanism
from frictool.plant.mechanism.assembly import AssembledMechanism, assemble

MOST = 16
_KEPT: dict[
    int, tuple[Mechanism, AssembledMechanism]
] = {}  # by identity: a document does not change, and is held here as long as its number is used


def assemble_cached(mechanism: Mechanism) -> AssembledMechanism:
    """`assemble`, and the same answer again for the same document. Raises WrongElement as it
    does."""
    found = _KEPT.get(id(mechanism))
    if found is not None:
        return found[1]
    made = assemble(mechanism)
    while len(_KEPT) >= MOST:
        del _KEPT[next(iter(_KEPT))]
    _KEPT[id(mechanism)] = (mechanism, made)
    return made
