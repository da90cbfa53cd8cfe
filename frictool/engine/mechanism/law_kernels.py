"""The kernels of friction laws as values that the engine calls by the law's row of
friction/law_registry.py.

=====  ==========
==============================================================================================
kind   name        how the engine takes it
=====  ==========
==============================================================================================
0      EXACT       static, without a band: sticks up to its breakaway, slips with the direction of
       the phase
1      SMOOTH      a regularised static law: a force of the velocity
2      DYNAMIC     its state is integrated, its memory moves after accepted steps
3      HYBRID      as printed, in its own fixed step: its mode is asked for at the beginning of each
4      BANDED      static with a band (2.32), (2.35): as HYBRID
=====  ==========
==============================================================================================

A machine holds the addresses of its laws' kernels, so that what calls them is compiled once for all
laws.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.runtime.kernels import function_pointer

Vector = NDArray[np.float64]
Places = NDArray[np.int64]
EXACT, SMOOTH, DYNAMIC, HYBRID, BANDED = range(5)
PROBES = (
    0.0,
    1e-6,
    1e-3,
    1.0,
    1e3,
)  # speeds at which a law that is a line is told from one that is none


def _by_address(kind: Any) -> Callable[..., Any]:
    """Code that calls the function of this type whose address is the first argument."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        called = builder.inttoptr(arguments[0], context.get_value_type(kind.ftype))
        return builder.call(called, arguments[1:])

    return code


def call_by_address(kind: Any) -> Any:
    """What an intrinsic returns that takes an address and the arguments of a function of this type,
    and calls it."""
    return kind.signature.return_type(types.int64, *kind.signature.args), _by_address(kind)


def by_address(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of an address and arguments, for kernels; `function` says which with `called`."""
    return cast(Callable[..., Any], intrinsic(function))


@by_address
def slip_force(_: Any, address: Any, v: Any, direction: Any, p: Any) -> Any:
    """slip_force of friction/law.py `StaticKernels`, at an address."""
    return call_by_address(s.SLIP_FORCE)


@by_address
def breakaway(_: Any, address: Any, direction: Any, p: Any) -> Any:
    """breakaway of `StaticKernels`."""
    return call_by_address(s.BREAKAWAY)


@by_address
def rate(_: Any, address: Any, z: Any, v: Any, p: Any, out: Any) -> Any:
    """rate of `DynamicKernels`."""
    return call_by_address(s.RATE)


@by_address
def force(_: Any, address: Any, z: Any, zdot: Any, v: Any, p: Any) -> Any:
    """force of `DynamicKernels`."""
    return call_by_address(s.FORCE)


@by_address
def commit(_: Any, address: Any, z: Any, v: Any, p: Any) -> Any:
    """commit of `DynamicKernels`."""
    return call_by_address(s.COMMIT)


def kind_of(law: Law, p: Vector) -> int:
    """How the engine takes a law with these parameters."""
    if isinstance(law.kernels, DynamicKernels):
        return DYNAMIC
    if isinstance(law.kernels, HybridKernels):
        return HYBRID
    if law.kernels.band(p) > 0.0:
        return BANDED
    return SMOOTH if law.approximation else EXACT


def straight_of(law: Law, p: Vector) -> int:
    """Where the viscous coefficient lies in p, of a law that is Coulomb friction p[0] and that in
    slip; 0 for any other.

    Such a force is a sum, which is quicker than a call. The numbers stay those of p, which may
    drift.
    """
    names = [parameter.name for parameter in law.parameters]
    if (
        not isinstance(law.kernels, StaticKernels)
        or kind_of(law, p) != EXACT
        or "viscous" not in names
    ):
        return 0
    place = names.index("viscous")
    line = all(law.kernels.slip_force(v, 1.0, p) == p[0] + p[place] * v for v in PROBES)
    return place if line else 0


def rest_of(law: Law, p: Vector) -> Vector:
    """The inner state of a contact that never moved; empty for a static law."""
    return (
        np.zeros(0)
        if isinstance(law.kernels, StaticKernels)
        else np.asarray(law.kernels.reset(p), dtype=np.float64)
    )


def sizes_of(law: Law, p: Vector) -> Vector:
    """What each inner state goes through up to the Coulomb force p[0]; inf for memory, which has no
    rate."""
    z = rest_of(law, p)
    if not isinstance(law.kernels, DynamicKernels):
        return np.full(z.size, np.inf)
    rates, still, sizes = np.zeros(z.size), np.zeros(z.size), np.full(z.size, np.inf)
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


@by_address
def band(_: Any, address: Any, p: Any) -> Any:
    """band of `StaticKernels`."""
    return call_by_address(s.BAND)


@by_address
def seen_velocity(_: Any, address: Any, v: Any, p: Any) -> Any:
    """seen_velocity of `StaticKernels`."""
    return call_by_address(s.SEEN_VELOCITY)


@by_address
def mode_after(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """mode_after of `HybridKernels`."""
    return call_by_address(s.MODE_AFTER)


@by_address
def enter(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """enter of `HybridKernels`."""
    return call_by_address(s.ENTER)


@by_address
def hybrid_force(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """force of `HybridKernels`."""
    return call_by_address(s.HYBRID_FORCE)


@by_address
def hybrid_acceleration(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """acceleration of `HybridKernels`."""
    return call_by_address(s.HYBRID_ACCELERATION)


@by_address
def hybrid_rate(_: Any, address: Any, mode: Any, v: Any, z: Any, p: Any, out: Any) -> Any:
    """rate of `HybridKernels`."""
    return call_by_address(s.HYBRID_RATE)


@by_address
def hybrid_commit(_: Any, address: Any, mode: Any, z: Any, p: Any) -> Any:
    """commit of `HybridKernels`."""
    return call_by_address(s.HYBRID_COMMIT)


# (name in the law's kernels, its type) by kind; a place in the addresses of a law
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


def addresses_of(laws: Sequence[Law], kinds: Sequence[int]) -> Places:
    """Addresses (n + 1, WIDTH) of the kernels of each friction's law, in the order of FUNCTIONS;
    the last row is left to the engine."""
    found = np.zeros((len(laws) + 1, WIDTH), dtype=np.int64)
    for row, law, kind in zip(found[:-1], laws, kinds, strict=True):
        for place, (name, signature) in enumerate(FUNCTIONS[kind]):
            row[place] = function_pointer(getattr(law.kernels, name), signature).address
    return found
