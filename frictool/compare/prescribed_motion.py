"""Friction of a law along a prescribed velocity, for the presliding test and law_probes.py.

Python code calls the law's kernels in each step, which is slow.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictool.errors import NoSolutionError
from frictool.friction.hybrid_kernels import STUCK
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.friction.static_kernels import sticking_force
from frictool.typing import Vector


def friction_along(law: Law, p: Vector, velocity: Vector, steps: Vector) -> Vector:
    """Return the friction (n,) [N | N m] at the end of each step of a prescribed velocity.

    At the start, the contact is undeformed and has no history. A hybrid law is evaluated with an
    infinite effort in the direction of motion.

    - velocity: velocity in each step, (n,), m/s | rad/s
    - steps: duration of each step, (n,), s

    Raises NoSolutionError if the law cannot be evaluated.
    """
    if isinstance(law.kernels, StaticKernels):
        slip = law.kernels.slip_force
        return np.array([slip(v, math.copysign(1.0, v), p) for v in velocity.tolist()])
    if isinstance(law.kernels, DynamicKernels):
        return _dynamic(law.name, law.kernels, p, velocity, steps)
    return _hybrid(law.name, law.kernels, p, velocity, steps)


def _dynamic(
    name: str, kernels: DynamicKernels, p: Vector, velocity: Vector, steps: Vector
) -> Vector:
    z = kernels.reset(p)
    begin = np.zeros_like(z)
    out = np.zeros_like(z)
    friction = np.empty(velocity.size)
    for k, (v, h) in enumerate(zip(velocity.tolist(), steps.tolist(), strict=True)):
        failed = kernels.rate(z, v, p, begin)
        failed += kernels.rate(z + h * begin, v, p, out)
        z += 0.5 * h * (begin + out)
        failed += kernels.commit(z, v, p) + kernels.rate(z, v, p, out)
        if failed:
            raise NoSolutionError(
                f"{name}: no friction can be computed at a velocity of {v:g} m/s (rad/s); "
                "check the parameters"
            )
        friction[k] = kernels.force(z, out, v, p)
    return friction


def _hybrid(
    name: str, kernels: HybridKernels, p: Vector, velocity: Vector, steps: Vector
) -> Vector:
    z = kernels.reset(p)
    mode = STUCK
    out = np.zeros_like(z)
    friction = np.empty(velocity.size)
    for k, (v, h) in enumerate(zip(velocity.tolist(), steps.tolist(), strict=True)):
        u = math.copysign(math.inf, v)
        after = kernels.mode_after(mode, v, u, z, p)
        failed = kernels.enter(after, v, u, z, p) if after != mode else 0
        mode = after
        failed += kernels.rate(mode, v, z, p, out)
        z += h * out
        failed += kernels.commit(mode, z, p)
        if failed:
            raise NoSolutionError(
                f"{name}: no friction can be computed at a velocity of {v:g} m/s (rad/s); "
                "check the parameters"
            )
        friction[k] = kernels.force(mode, v, u, z, p)
    return friction


def law_as_printed(law: Law, p: Vector) -> Callable[[float, float], tuple[float, float]]:
    """Return a static law as printed in the thesis: a function of the velocity v and effort u.

    The function returns the friction and the velocity with which the mass moves. This velocity is
    v; a law that treats low speeds as rest returns 0 instead of a low v.
    """
    kernels = law.kernels
    assert isinstance(kernels, StaticKernels)
    band = kernels.band(p)

    def printed(v: float, u: float) -> tuple[float, float]:
        if abs(v) <= band and not law.approximation:
            return sticking_force(
                u, kernels.breakaway(1.0, p), kernels.breakaway(-1.0, p)
            ), kernels.seen_velocity(v, p)
        return kernels.slip_force(v, math.copysign(1.0, v), p), kernels.seen_velocity(v, p)

    return printed
