"""The kernels of friction laws as values that the engine calls by the law's row of friction/table.py.

=====  ==========  ==============================================================================================
kind   name        how the engine takes it
=====  ==========  ==============================================================================================
0      EXACT       static, without a band: sticks up to its breakaway, slips with the direction of the phase
1      SMOOTH      a regularised static law: a force of the velocity
2      DYNAMIC     its state is integrated, its memory moves after accepted steps
3      HYBRID      as printed, in its own fixed step: its mode is asked for at the beginning of each
4      BANDED      static with a band (2.32), (2.35): as HYBRID
=====  ==========  ==============================================================================================

Laws that no block of a mechanism has are not loaded: another's kernel stands in their place in the tuples.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.friction import ideal_coulomb, lugre
from frictool.friction import signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.kernels import pointer

Vector = NDArray[np.float64]
EXACT, SMOOTH, DYNAMIC, HYBRID, BANDED = range(5)


class LawKernels(NamedTuple):
    """Each field: a pointer for each row of the table."""

    slip_force: Any
    breakaway: Any
    rate: Any
    force: Any
    commit: Any


def kind_of(law: Law, p: Vector) -> int:
    """How the engine takes a law with these parameters."""
    if isinstance(law.kernels, DynamicKernels):
        return DYNAMIC
    if isinstance(law.kernels, HybridKernels):
        return HYBRID
    if law.kernels.band(p) > 0.0:
        return BANDED
    return SMOOTH if law.approximation else EXACT


def rest_of(law: Law, p: Vector) -> Vector:
    """The inner state of a contact that never moved; empty for a static law."""
    return np.zeros(0) if isinstance(law.kernels, StaticKernels) else np.asarray(law.kernels.reset(p), dtype=np.float64)


def sizes_of(law: Law, p: Vector) -> Vector:
    """What each inner state goes through up to the Coulomb force p[0]; inf for memory, which has no rate."""
    z = rest_of(law, p)
    if not isinstance(law.kernels, DynamicKernels):
        return np.full(z.size, np.inf)
    rates, still, sizes = np.zeros(z.size), np.zeros(z.size), np.full(z.size, np.inf)
    law.kernels.rate(z, 1.0, p, rates)
    moved = 1e-9
    change = abs(law.kernels.force(z + moved * rates, still, 0.0, p) - law.kernels.force(z, still, 0.0, p)) / moved
    moving = rates != 0.0
    sizes[moving] = np.abs(rates[moving]) * p[0] / max(change, 1e-300)
    return sizes


def kernels_of(rows: Sequence[Law], used: Sequence[int]) -> LawKernels:
    """The kernels of the laws of the table's rows that are used."""

    def column(kinds: type, stand_in: Law, name: str, kind: Any) -> Any:
        chosen = [law if row in used and isinstance(law.kernels, kinds) else stand_in for row, law in enumerate(rows)]
        return tuple(pointer(getattr(law.kernels, name), kind) for law in chosen)

    return LawKernels(
        column(StaticKernels, ideal_coulomb.LAW, "slip_force", s.SLIP_FORCE),
        column(StaticKernels, ideal_coulomb.LAW, "breakaway", s.BREAKAWAY),
        column(DynamicKernels, lugre.LAW, "rate", s.RATE),
        column(DynamicKernels, lugre.LAW, "force", s.FORCE),
        column(DynamicKernels, lugre.LAW, "commit", s.COMMIT),
    )
