"""Cache of assembled mechanisms, which the steps of a reduction use repeatedly."""

from __future__ import annotations

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Mechanism
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism

MOST = 16  # largest number of mechanisms in the cache
# key: id of a document; the cache also keeps the document, so that the id stays unique
_KEPT: dict[int, tuple[Mechanism, AssembledMechanism]] = {}


def assemble_cached(mechanism: Mechanism) -> AssembledMechanism:
    """Return `assemble(mechanism)`, from the cache if possible; may raise ElementError."""
    cached = _KEPT.get(id(mechanism))
    if cached is not None:
        return cached[1]
    made = assemble(mechanism)
    while len(_KEPT) >= MOST:
        del _KEPT[next(iter(_KEPT))]
    _KEPT[id(mechanism)] = (mechanism, made)
    return made
