"""Stiffness and elastic limit of the elasto-plastic law from slow effort loops below breakaway.

    dz/dx = 1 - alpha(z) stiffness |z|/F_s if z has the sign of the motion, else 1
    F = stiffness z

z is the deflection, x the position, F the friction, and F_s the breakaway. This is thesis (2.44) at
zero speed, with alpha from thesis (2.45) and (2.46). The largest deflection is z_max =
F_s/stiffness. The search variable for the elastic limit z_ba is the ratio z_ba/(z_max - z_ba),
called odds.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.identify.fit_result import Interval
from frictool.identify.presliding.loops import PreslidingLoops
from frictool.identify.presliding.path_fit import PreslidingFit, fit_path
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

FINE = 0.02  # longest integration step, relative to z_max


@kernel
def elasto_plastic_path(
    position: Vector,
    starts: NDArray[np.bool_],
    stiffness: float,
    breakaway: float,
    share: float,
    out: Vector,
) -> None:
    """Compute the friction of the elasto-plastic law along a path.

    - position: positions of the path, (n,), rad | m
    - starts: True for the first row of a record, at which friction is 0, (n,)
    - stiffness, breakaway: stiffness [N m/rad | N/m] and breakaway [N m | N] of the law
    - share: z_ba/z_max, the relative elastic limit
    - out: result, friction at each position, (n,), N m | N
    """
    limit = breakaway / stiffness
    z = 0.0
    for k in range(position.shape[0]):
        if starts[k]:
            z = 0.0
            out[k] = 0.0
            continue
        moved = position[k] - position[k - 1]
        steps = max(1, math.ceil(abs(moved) / (FINE * limit)))
        step = moved / steps
        for _ in range(steps):
            middle = z + 0.5 * step * slope(z, step, limit, share)
            before = z
            z += step * slope(middle, step, limit, share)
            if z == before:  # full slip: further steps do not change z
                break
        out[k] = stiffness * z


@kernel
def slope(z: float, direction: float, limit: float, share: float) -> float:
    """Return dz/dx, the change of the deflection z with the position x.

    - direction: any number with the sign of the motion
    - limit, share: largest deflection z_max, and elastic limit z_ba divided by z_max
    """
    size = abs(z) / limit
    if z * direction <= 0.0 or size < share:
        return 1.0
    alpha = (
        1.0
        if size >= 1.0
        else 0.5 * (math.sin(math.pi * (size - 0.5 * (1.0 + share)) / (1.0 - share)) + 1.0)
    )
    return 1.0 - alpha * size


def _path(loops: PreslidingLoops, value: Vector) -> Vector:
    out = np.empty(loops.position.size)
    elasto_plastic_path(
        loops.position,
        loops.starts,
        float(value[0]),
        loops.breakaway.value,
        share_of(float(value[1])),
        out,
    )
    return out


def elasto_plastic(loops: PreslidingLoops, confidence: float) -> PreslidingFit:
    """Return the fit of the stiffness sigma_0 [N m/rad | N/m] and the elastic limit z_ba [rad | m].

    Raises UnusableLogs if the loops do not determine both parameters.
    """
    fit = fit_path(
        loops, _path, np.array([2.0 * loops.breakaway.value / loops.reach, 1.0]), confidence
    )
    stiffness, odds = fit.parameters
    limit = loops.breakaway.value / stiffness.value
    elastic = limit * share_of(odds.value)
    own = [np.log(share_of(end) / share_of(odds.value)) for end in (odds.low, odds.high)]
    low, high = (
        float(elastic * np.exp(side * np.hypot(part, np.log(stiffness.high / stiffness.value))))
        for side, part in zip((-1.0, 1.0), own, strict=True)
    )
    return PreslidingFit(
        (stiffness, Interval(elastic, low, min(high, limit))), fit.force_error, fit.held_out
    )


def share_of(odds: float) -> float:
    """Return the relative elastic limit z_ba/z_max (module docstring) for `odds`."""
    return odds / (1.0 + odds)
