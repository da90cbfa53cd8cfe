"""Calls of the kernels of friction laws by address.

The record of a law in friction/law_registry.py names its kernels. The engine treats each kind of
law in its own way:

====  =======  ==================================================================================
kind  name     treatment in the engine
====  =======  ==================================================================================
0     EXACT    static law with exact rest: the block sticks up to the breakaway, and slips in the
               direction that the mode states
1     SMOOTH   regularised static law: a force that depends on the velocity
2     DYNAMIC  the state of the law is integrated, the memory is updated after accepted steps
3     HYBRID   the mode of the law is updated at the beginning of each step of a fixed length
4     BANDED   static law that treats low speeds as rest (thesis 2.32, 2.35); the mode of the law
               is updated as for HYBRID
====  =======  ==================================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from frictool.engine.mechanism.address_calls import call_by_address
from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.runtime.kernels import function_pointer
from frictool.typing import IntVector, Vector

EXACT, SMOOTH, DYNAMIC, HYBRID, BANDED = range(5)
PROBES = (0.0, 1e-6, 1e-3, 1.0, 1e3)  # speeds at which a law's friction is tested for linearity


# calls of the kernels of friction/law.py `StaticKernels`, `DynamicKernels` and `HybridKernels`;
# the first argument is the address
slip_force = call_by_address(s.SLIP_FORCE)
breakaway = call_by_address(s.BREAKAWAY)
band = call_by_address(s.BAND)
seen_velocity = call_by_address(s.SEEN_VELOCITY)
rate = call_by_address(s.RATE)
force = call_by_address(s.FORCE)
commit = call_by_address(s.COMMIT)
mode_after = call_by_address(s.MODE_AFTER)
enter = call_by_address(s.ENTER)
hybrid_force = call_by_address(s.HYBRID_FORCE)
hybrid_acceleration = call_by_address(s.HYBRID_ACCELERATION)
hybrid_rate = call_by_address(s.HYBRID_RATE)
hybrid_commit = call_by_address(s.HYBRID_COMMIT)


def kind_of(law: Law, p: Vector) -> int:
    """Return the kind (EXACT to BANDED) of a law with the parameters p."""
    if isinstance(law.kernels, DynamicKernels):
        return DYNAMIC
    if isinstance(law.kernels, HybridKernels):
        return HYBRID
    if law.kernels.band(p) > 0.0:
        return BANDED
    return SMOOTH if law.approximation else EXACT


def straight_of(law: Law, p: Vector) -> int:
    """Return the index in p of the viscous coefficient if slip friction is linear in speed, else 0.

    The friction in slip is then p[0] + viscous * speed.
    """
    names = [parameter.name for parameter in law.parameters]
    if (
        not isinstance(law.kernels, StaticKernels)
        or kind_of(law, p) != EXACT
        or "viscous" not in names
    ):
        return 0
    index = names.index("viscous")
    line = all(law.kernels.slip_force(v, 1.0, p) == p[0] + p[index] * v for v in PROBES)
    return index if line else 0


def rest_of(law: Law, p: Vector) -> Vector:
    """Return the internal state (z,) of a law before any motion; empty for a static law."""
    return (
        np.zeros(0)
        if isinstance(law.kernels, StaticKernels)
        else np.asarray(law.kernels.reset(p), dtype=np.float64)
    )


def sizes_of(law: Law, p: Vector) -> Vector:
    """Return the scale (z,) of each internal state of a law, for error tolerances.

    When a contact first moves, the force grows with the displacement. Let d be the Coulomb force
    p[0] divided by the initial slope of the force. The scale of a state is the change of the state
    over the displacement d. The scale is inf for states that do not change at first, such as
    memory. It is also inf for all states of a law that is not dynamic.
    """
    z = rest_of(law, p)
    if not isinstance(law.kernels, DynamicKernels):
        return np.full(z.size, np.inf)
    rates = np.zeros(z.size)
    still = np.zeros(z.size)
    sizes = np.full(z.size, np.inf)
    law.kernels.rate(z, 1.0, p, rates)
    moved = 1e-9
    change = (
        abs(
            law.kernels.force(z + moved * rates, still, 0.0, p)
            - law.kernels.force(z, still, 0.0, p)
        )
        / moved
    )
    moving = rates != 0.0
    sizes[moving] = np.abs(rates[moving]) * p[0] / max(change, 1e-300)
    return sizes


# (name in the law's kernels, its type) by kind, in the order of a law's addresses
STATIC = (("slip_force", s.SLIP_FORCE), ("breakaway", s.BREAKAWAY))
FUNCTIONS: dict[int, tuple[tuple[str, Any], ...]] = {
    EXACT: STATIC,
    SMOOTH: STATIC,
    DYNAMIC: (("rate", s.RATE), ("force", s.FORCE), ("commit", s.COMMIT)),
    HYBRID: (
        ("mode_after", s.MODE_AFTER),
        ("enter", s.ENTER),
        ("force", s.HYBRID_FORCE),
        ("acceleration", s.HYBRID_ACCELERATION),
        ("rate", s.HYBRID_RATE),
        ("commit", s.HYBRID_COMMIT),
    ),
    BANDED: (*STATIC, ("band", s.BAND), ("seen_velocity", s.SEEN_VELOCITY)),
}
WIDTH = 6


def addresses_of(laws: Sequence[Law], kinds: Sequence[int]) -> IntVector:
    """Return the addresses (n + 1, WIDTH) of the kernels of n friction laws.

    Row i belongs to law i, with columns in the order of FUNCTIONS. The last row is reserved for
    kernels of the engine.
    """
    addresses = np.zeros((len(laws) + 1, WIDTH), dtype=np.int64)
    for row, law, kind in zip(addresses[:-1], laws, kinds, strict=True):
        for index, (name, signature) in enumerate(FUNCTIONS[kind]):
            row[index] = function_pointer(getattr(law.kernels, name), signature).address
    return addresses
