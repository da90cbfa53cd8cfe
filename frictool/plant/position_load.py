"""Load of an axis that depends on its position: a spring, and harmonics (gravity, torque ripple).

    load(x) = stiffness x + sum_j (sine_j sin(number_j x) + cosine_j cos(number_j x))

A positive load opposes a positive effort. A constant load is part of the axis's offset. Gravity
on an arm is the harmonic with number 1 on a rotary axis. On a linear axis `number` is an angular
wave number [1/m]. The kernels' array is [stiffness, number, sine, cosine, ...]. The engine
integrates the load with the motion: `with_load` appends the load to the parameters of an axis with
`AxisLaws` (plant/axis_friction_laws.py).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.plant.axis import BREAKAWAY, COULOMB, OFFSET, VISCOUS
from frictool.plant.axis_friction_laws import (
    BREAKAWAY_PAIR,
    COULOMB_MAPS,
    COULOMB_PAIR,
    DYNAMIC_SIZE,
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
from frictool.typing import Vector

TERM_SIZE = 3


class LoadHarmonic(NamedTuple):
    """One harmonic: `number` in 1/rad | 1/m, `sine` and `cosine` in N m | N."""

    number: float
    sine: float
    cosine: float


class PositionLoad(NamedTuple):
    """Load of an axis, with `stiffness` in N m/rad | N/m; the default is no load."""

    stiffness: float = 0.0
    harmonics: tuple[LoadHarmonic, ...] = ()

    def as_array(self) -> Vector:
        """Return the array (1 + 3 h,) for kernels, with h harmonics; it is empty without a load."""
        if self == PositionLoad():
            return np.empty(0)
        return np.array(
            [self.stiffness, *(value for harmonic in self.harmonics for value in harmonic)],
            dtype=np.float64,
        )

    def at(self, positions: Vector) -> Vector:
        """Return the load (n,) [N m | N] at positions (n,) [rad | m]."""
        total: Vector = self.stiffness * positions
        for number, sine, cosine in self.harmonics:
            total = total + sine * np.sin(number * positions) + cosine * np.cos(number * positions)
        return total


@kernel
def load_effort(load: Vector, x: float) -> float:
    """Return the load [N m | N] at x [rad | m]; `load` is the result of `PositionLoad.as_array`."""
    if load.shape[0] == 0:
        return 0.0
    total = float(load[0]) * x
    for term in range(1, load.shape[0], TERM_SIZE):
        angle = load[term] * x
        total += load[term + 1] * math.sin(angle) + load[term + 2] * math.cos(angle)
    return total


@kernel
def load_slope(load: Vector, x: float) -> float:
    """Return the derivative of `load_effort` with respect to x [N m/rad | N/m]."""
    if load.shape[0] == 0:
        return 0.0
    total = float(load[0])
    for term in range(1, load.shape[0], TERM_SIZE):
        angle = load[term] * x
        total += load[term] * (load[term + 1] * math.cos(angle) - load[term + 2] * math.sin(angle))
    return total


@kernel
def with_load(axis: Vector, load: Vector) -> Vector:
    """Return a copy of the parameters `axis` with `load` appended.

    An axis without `AxisLaws` gets the default `AxisLaws`, which have no effect.
    """
    return axis.copy() if load.shape[0] == 0 else appended(axis, load)


@kernel
def appended(axis: Vector, values: Vector) -> Vector:
    """Return the parameters `axis`, with default `AxisLaws` if missing, followed by `values`."""
    size = max(axis.shape[0], EXTENDED_SIZE)
    out = np.zeros(size + values.shape[0])
    for i in range(axis.shape[0]):
        out[i] = axis[i]
    for i in range(values.shape[0]):
        out[size + i] = values[i]
    if axis.shape[0] == PLAIN_SIZE:
        for side in range(2):
            out[VISCOUS_PAIR + side], out[COULOMB_PAIR + side] = axis[VISCOUS], axis[COULOMB]
            out[BREAKAWAY_PAIR + side] = axis[BREAKAWAY]
        out[STOP_PAIR] = -math.inf
        out[STOP_PAIR + 1] = math.inf
        out[STRIBECK_EXPONENT], out[FRESH] = 2.0, 1.0
        for start in range(REGIMES, COULOMB_MAPS, REGIME_SIZE):
            out[start] = math.inf
    return out


@inner_kernel
def load_start(p: Vector) -> int:
    """Return the index of the load in the parameters p of an axis with `AxisLaws`."""
    return EXTENDED_SIZE + int(p[DYNAMIC_SIZE])


@inner_kernel
def is_loaded(p: Vector) -> bool:
    """Return True if the parameters p of an axis with `AxisLaws` include a load."""
    return bool(p.shape[0] > load_start(p))


@inner_kernel
def opposing_effort(p: Vector, x: float) -> float:
    """Return offset plus load [N m | N] at the position x [rad | m].

    p: parameters of an axis with `AxisLaws`.
    """
    return (
        float(p[OFFSET]) + load_effort(p[load_start(p) :], x) if is_loaded(p) else float(p[OFFSET])
    )


@inner_kernel
def load_size(p: Vector, x: float) -> float:
    """Return the sum of the magnitudes of the load's terms [N m | N] at the position x [rad | m].

    p: parameters of an axis with `AxisLaws`.
    """
    if not is_loaded(p):
        return 0.0
    first = load_start(p)
    total = abs(p[first] * x)
    for term in range(first + 1, p.shape[0], TERM_SIZE):
        total += abs(p[term + 1]) + abs(p[term + 2])
    return float(total)
