"""One compiled driver per kind: it takes any law of the kind as kernels."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictool.friction.hybrid_kernels import SLIPPING, STUCK
from frictool.friction.law import DynamicKernels, HybridKernels, StaticKernels
from frictool.friction.law_signatures import SIGNATURES
from frictool.runtime.kernels import function_pointer, kernel


def pointers(kernels: StaticKernels | DynamicKernels | HybridKernels) -> tuple[Any, ...]:
    """Return the arguments of the drivers below that stand for the kernels."""
    return tuple(
        function_pointer(kernel, kind)
        for kernel, kind in zip(kernels, SIGNATURES[type(kernels)], strict=True)
    )


FORCE, STATE, POSITION, VELOCITY, MODE, EFFORT = 0, 1, 0, 1, 2, 3


@kernel
def static_values(slip_force, breakaway, band, seen_velocity, velocities, p):
    """Return rows (slip force, breakaway, band, seen velocity) at each velocity.

    The direction is that of the velocity.
    """
    out = np.zeros((velocities.shape[0], 4))
    for k in range(velocities.shape[0]):
        v = velocities[k]
        direction = 1.0 if v >= 0.0 else -1.0
        out[k, 0] = slip_force(v, direction, p)
        out[k, 1] = breakaway(direction, p)
        out[k, 2] = band(p)
        out[k, 3] = seen_velocity(v, p)
    return out


@kernel
def dynamic_run(rate, force, commit, reset, velocities, step, p):
    """Rows (force, z[0]) along velocities, straight between samples; Runge-Kutta of order 4. Row 0
    is the start."""
    z = reset(p)
    k1, k2, k3, k4 = np.zeros_like(z), np.zeros_like(z), np.zeros_like(z), np.zeros_like(z)
    out = np.zeros((velocities.shape[0], 2))
    for k in range(velocities.shape[0]):
        v = velocities[k]
        status = rate(z, v, p, k1)
        out[k, 0], out[k, 1] = force(z, k1, v, p), z[0]
        if k + 1 == velocities.shape[0]:
            break
        after = velocities[k + 1]
        middle = 0.5 * (v + after)
        status += rate(z + 0.5 * step * k1, middle, p, k2)
        status += rate(z + 0.5 * step * k2, middle, p, k3)
        status += rate(z + step * k3, after, p, k4)
        z += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        status += commit(z, after, p)
        if status != 0:
            out[k + 1 :] = np.nan
            break
    return out


@kernel
def hybrid_run(
    mode_after, enter, force, acceleration, rate, commit, reset, efforts, stiffness, step, p
):
    """Rows (x, v, mode, friction) of a body at rest under the efforts, minus stiffness x; midpoint
    rule, mode held in each step."""
    z = reset(p)
    slope = np.zeros_like(z)
    mode, x, v = STUCK, 0.0, 0.0
    out = np.zeros((efforts.shape[0], 4))
    for k in range(efforts.shape[0]):
        u = efforts[k] - stiffness * x
        after = mode_after(mode, v, u, z, p)
        status = 0
        if after != mode:
            mode = after
            status += enter(mode, v, u, z, p)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = x, v, float(mode), force(mode, v, u, z, p)
        status += rate(mode, v, z, p, slope)
        half = v + 0.5 * step * acceleration(mode, v, u, z, p)
        middle = z + 0.5 * step * slope
        status += rate(mode, half, middle, p, slope)
        v += step * acceleration(mode, half, u, middle, p)
        z += step * slope
        x += step * half
        status += commit(mode, z, p)
        if status != 0:
            out[k + 1 :] = np.nan
            break
    return out


__all__ = ["SLIPPING", "STUCK", "dynamic_run", "hybrid_run", "pointers", "static_values"]
