"""What loads an axis beside friction, as a function of its position: a spring, and harmonics
(gravity on an arm, torque ripple).

    load(x) = stiffness x + sum_j (sine_j sin(number_j x) + cosine_j cos(number_j x))

It opposes a positive effort, as the offset does, which holds its constant part. Gravity is the
harmonic of number 1 on a rotary axis (per rad; per m on a linear one, where `number` is a wave
number). The kernels' array: [stiffness, number, sine, cosine, ...].

The engine integrates the load with the motion: `under_load` puts it behind the parameters of an
axis with laws (plant/axis_friction_laws.py).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.plant.axis import BREAKAWAY, COULOMB, OFFSET, VISCOUS
from frictool.plant.axis_friction_laws import (
    BREAKAWAY_PAIR,
    COULOMB_MAPS,
    COULOMB_PAIR,
    EXTENDED_SIZE,
    FRESH,
    PLAIN_SIZE,
    REGIME_SIZE,
    REGIMES,
    STOP_PAIR,
    STRIBECK_EXPONENT,
    VISCOUS_PAIR,
)
from frictool.runtime.kernels import inner_kernel, kernel

Vector = NDArray[np.float64]
TERM_SIZE = 3


class LoadHarmonic(NamedTuple):
    """`number` in 1/rad | 1/m, `sine` and `cosine` in N m | N."""

    number: float
    sine: float
    cosine: float


class PositionLoad(NamedTuple):
    """SI; `stiffness` in N m/rad | N/m. The default is no load."""

    stiffness: float = 0.0
    harmonics: tuple[LoadHarmonic, ...] = ()

    def as_array(self) -> Vector:
        """For the kernels: (1 + 3 h,), empty where there is no load."""
        if self == PositionLoad():
            return np.empty(0)
        return np.array(
            [self.stiffness, *(value for harmonic in self.harmonics for value in harmonic)],
            dtype=np.float64,
        )

    def at(self, positions: Vector) -> Vector:
        """The load (n,) [N m | N] at positions (n,) [rad | m]."""
        total: Vector = self.stiffness * positions
        for number, sine, cosine in self.harmonics:
            total = total + sine * np.sin(number * positions) + cosine * np.cos(number * positions)
        return total


@kernel
def load_effort(load: Vector, x: float) -> float:
    """The load [N m | N] at x [rad | m]; `load` (1 + 3 h,) or empty."""
    if load.shape[0] == 0:
        return 0.0
    total = float(load[0]) * x
    for term in range(1, load.shape[0], TERM_SIZE):
        angle = load[term] * x
        total += load[term + 1] * math.sin(angle) + load[term + 2] * math.cos(angle)
    return total


@kernel
def with_load(axis: Vector, load: Vector) -> Vector:
    """Return a copy of the parameters `axis` with `load` behind them; a plain axis gets laws that
    change nothing in between."""
    if load.shape[0] == 0:
        return axis.copy()
    out = np.zeros(EXTENDED_SIZE + load.shape[0])
    out[: axis.shape[0]] = axis
    out[EXTENDED_SIZE:] = load
    if axis.shape[0] == PLAIN_SIZE:
        for side in range(2):
            out[VISCOUS_PAIR + side], out[COULOMB_PAIR + side] = axis[VISCOUS], axis[COULOMB]
            out[BREAKAWAY_PAIR + side] = axis[BREAKAWAY]
        out[STOP_PAIR], out[STOP_PAIR + 1] = -math.inf, math.inf
        out[STRIBECK_EXPONENT], out[FRESH] = 2.0, 1.0
        out[REGIMES:COULOMB_MAPS:REGIME_SIZE] = math.inf
    return out


@inner_kernel
def is_loaded(p: Vector) -> bool:
    """Return whether a load stands behind the parameters."""
    return bool(p.shape[0] > EXTENDED_SIZE)


@inner_kernel
def opposing_effort(p: Vector, x: float) -> float:
    """Offset and load [N m | N] of an axis with laws at x [rad | m]."""
    return (
        float(p[OFFSET]) + load_effort(p[EXTENDED_SIZE:], x) if is_loaded(p) else float(p[OFFSET])
    )


@inner_kernel
def load_size(p: Vector, x: float) -> float:
    """Sum of the magnitudes of the load's terms at x [N m | N]."""
    if not is_loaded(p):
        return 0.0
    total = abs(p[EXTENDED_SIZE] * x)
    for term in range(EXTENDED_SIZE + 1, p.shape[0], TERM_SIZE):
        total += abs(p[term + 1]) + abs(p[term + 2])
    return float(total)
