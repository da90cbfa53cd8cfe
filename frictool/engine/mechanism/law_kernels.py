"""Kernels of friction laws as addresses, called by the law's row of friction/law_registry.py.

====  =======  ==================================================================================
kind  name     treatment in the engine
====  =======  ==================================================================================
0     EXACT    static, without a band: sticks up to its breakaway, slips in the direction of the
               phase
1     SMOOTH   regularised static law: a force that depends on the velocity
2     DYNAMIC  its state is integrated, its memory is updated after accepted steps
3     HYBRID   as printed, in its own fixed step, with the mode updated at each step's beginning
4     BANDED   static with a band (2.32), (2.35): as HYBRID
====  =======  ==================================================================================

A compiled mechanism holds the addresses of its laws' kernels, so that their callers are compiled
once for all laws.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from numba import types
from numba.extending import intrinsic

from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.runtime.kernels import function_pointer
from frictool.typing import IntVector, Vector

EXACT, SMOOTH, DYNAMIC, HYBRID, BANDED = range(5)
PROBES = (0.0, 1e-6, 1e-3, 1.0, 1e3)  # speeds at which a law is tested for being a straight line


def _by_address(kind: Any) -> Callable[..., Any]:
    """Return a code generator that calls the function of this type at the address in argument 0."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        called = builder.inttoptr(arguments[0], context.get_value_type(kind.ftype))
        return builder.call(called, arguments[1:])

    return code


def call_by_address(kind: Any) -> Any:
    """Return signature and code of an intrinsic that calls a function of type `kind` by address."""
    return kind.signature.return_type(types.int64, *kind.signature.args), _by_address(kind)


def by_address(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return an intrinsic for kernels that calls the function at its first argument, an address.

    `function` returns the signature and code for the type of the called function.
    """
    return cast(Callable[..., Any], intrinsic(function))


@by_address
def slip_force(_: Any, address: Any, v: Any, direction: Any, p: Any) -> Any:
    """Call slip_force of friction/law.py `StaticKernels` at an address."""
    return call_by_address(s.SLIP_FORCE)


@by_address
def breakaway(_: Any, address: Any, direction: Any, p: Any) -> Any:
    """Call breakaway of `StaticKernels`."""
    return call_by_address(s.BREAKAWAY)


@by_address
def rate(_: Any, address: Any, z: Any, v: Any, p: Any, out: Any) -> Any:
    """Call rate of `DynamicKernels`."""
    return call_by_address(s.RATE)


@by_address
def force(_: Any, address: Any, z: Any, zdot: Any, v: Any, p: Any) -> Any:
    """Call force of `DynamicKernels`."""
    return call_by_address(s.FORCE)


@by_address
def commit(_: Any, address: Any, z: Any, v: Any, p: Any) -> Any:
    """Call commit of `DynamicKernels`."""
    return call_by_address(s.COMMIT)


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
    """Return the index in p of the viscous coefficient if slip friction is a straight line, else 0.

    The line is p[0] + viscous * speed. Kernels then compute this sum instead of calling the law,
    which is slower. They read p at each evaluation, because its values may drift.
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
    """Return a law's inner state (z,) for a contact that never moved; empty for a static law."""
    return (
        np.zeros(0)
        if isinstance(law.kernels, StaticKernels)
        else np.asarray(law.kernels.reset(p), dtype=np.float64)
    )


def sizes_of(law: Law, p: Vector) -> Vector:
    """Return the scale (z,) of each inner state of a law, for error tolerances.

    The scale is the change of the state, from a contact that never moved, at which the force
    reaches the Coulomb force p[0] if it grows linearly. It is inf for states that do not change at
    the start of motion, such as memory, and for all states of laws that are not dynamic.
    """
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
    """Call band of `StaticKernels`."""
    return call_by_address(s.BAND)


@by_address
def seen_velocity(_: Any, address: Any, v: Any, p: Any) -> Any:
    """Call seen_velocity of `StaticKernels`."""
    return call_by_address(s.SEEN_VELOCITY)


@by_address
def mode_after(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """Call mode_after of `HybridKernels`."""
    return call_by_address(s.MODE_AFTER)


@by_address
def enter(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """Call enter of `HybridKernels`."""
    return call_by_address(s.ENTER)


@by_address
def hybrid_force(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """Call force of `HybridKernels`."""
    return call_by_address(s.HYBRID_FORCE)


@by_address
def hybrid_acceleration(_: Any, address: Any, mode: Any, v: Any, u: Any, z: Any, p: Any) -> Any:
    """Call acceleration of `HybridKernels`."""
    return call_by_address(s.HYBRID_ACCELERATION)


@by_address
def hybrid_rate(_: Any, address: Any, mode: Any, v: Any, z: Any, p: Any, out: Any) -> Any:
    """Call rate of `HybridKernels`."""
    return call_by_address(s.HYBRID_RATE)


@by_address
def hybrid_commit(_: Any, address: Any, mode: Any, z: Any, p: Any) -> Any:
    """Call commit of `HybridKernels`."""
    return call_by_address(s.HYBRID_COMMIT)


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
    """Return the addresses (n + 1, WIDTH) of the kernels of each friction's law.

    Columns are in the order of FUNCTIONS; the last row is for the engine's own kernels.
    """
    found = np.zeros((len(laws) + 1, WIDTH), dtype=np.int64)
    for row, law, kind in zip(found[:-1], laws, kinds, strict=True):
        for place, (name, signature) in enumerate(FUNCTIONS[kind]):
            row[place] = function_pointer(getattr(law.kernels, name), signature).address
    return found
