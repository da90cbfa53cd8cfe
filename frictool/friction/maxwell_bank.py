"""A bank of Maxwell-slip elements: massless springs in parallel, each with a slip force.

    F = sum_i w_i F_s clip(delta_i/(d_i z_max), -1, 1)

F_s is the breakaway and z_max the largest presliding displacement. The deflection delta_i of
element i follows the body and stops at +-d_i z_max (annex A of the thesis). The parameter array p
of a law ends with [d_1 .. d_N, w_1 .. w_N]: yield displacements d in units of z_max and slip forces
w in units of F_s. The sum of all w is 1. The bank has the same force as Masing's hysteresis with a
piecewise linear virgin curve.
"""

from __future__ import annotations

import numpy as np

from frictool.friction.virgin_curve import virgin_force
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

ELEMENTS = 10


def bank_tail(displacements: Vector, forces: Vector) -> Vector:
    """Return [d, w] (2 N,) of N elements whose virgin curve passes through (0, 0) and N points.

    d are the yield displacements and w the slip forces (module docstring). `displacements` and
    `forces` (N,) are in any units. Raises ValueError if the displacements do not increase from 0,
    or if the slope of the curve is negative or increases at a point.
    """
    z = np.concatenate([[0.0], np.asarray(displacements, dtype=np.float64)])
    f = np.concatenate([[0.0], np.asarray(forces, dtype=np.float64)])
    if (
        z.shape != f.shape
        or z.size < 2
        or not np.all(np.isfinite([z, f]))
        or np.any(np.diff(z) <= 0.0)
    ):
        raise ValueError(
            f"virgin curve: found {z.size - 1} displacements and {f.size - 1} forces; allowed: "
            "displacements that increase from 0, and a finite force for each"
        )
    slopes = np.append(np.diff(f) / np.diff(z), 0.0)
    stiffness = -np.diff(slopes)
    if slopes[0] <= 0.0 or np.any(slopes < 0.0) or np.any(stiffness < -1e-12 * slopes[0]):
        steps = ", ".join(f"{slope:g}" for slope in slopes[:-1])
        raise ValueError(
            f"slopes of the virgin curve are {steps}; allowed: slopes >= 0 that fall from point to "
            "point"
        )
    weights = np.maximum(stiffness, 0.0) * z[1:]
    return np.concatenate([z[1:] / z[-1], weights / weights.sum()])


def parabolic_bank() -> Vector:
    """Return [d, w] (2 N,) of elements that follow the parabola of friction/virgin_curve.py."""
    z = np.arange(1, ELEMENTS + 1) / ELEMENTS
    return bank_tail(z, np.array([virgin_force(point, 1.0, 1.0) for point in z]))


@kernel
def bank_force(
    deflections: Vector, moved: float, tail: Vector, breakaway: float, limit: float
) -> float:
    """Return the force [N | N m] after a monotonic movement by `moved` [m | rad].

    `limit` is z_max, the largest presliding displacement [m | rad]. The deflections (N,) of the
    elements are not changed.
    """
    count = deflections.shape[0]
    total = 0.0
    for i in range(count):
        stretch = (deflections[i] + moved) / (tail[i] * limit)
        total += tail[count + i] * min(max(stretch, -1.0), 1.0)
    return breakaway * total


@kernel
def bank_move(deflections: Vector, moved: float, tail: Vector, limit: float) -> None:
    """Move the deflections (N,) by `moved` [m | rad] in place; element i slips at +-d_i z_max.

    `limit` is z_max [m | rad].
    """
    for i in range(deflections.shape[0]):
        bound = tail[i] * limit
        deflections[i] = min(max(deflections[i] + moved, -bound), bound)
