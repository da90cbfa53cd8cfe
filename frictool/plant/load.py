"""What loads an axis beside friction, as a function of its position: a spring, and harmonics (gravity on an arm, torque ripple).

    load(x) = stiffness x + sum_j (sine_j sin(number_j x) + cosine_j cos(number_j x))

It opposes a positive effort, as the offset does, which holds its constant part. Gravity is the harmonic of number 1 on a rotary axis
(per rad; per m on a linear one, where `number` is a wave number). The kernels' array: [stiffness, number, sine, cosine, ...].
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import kernel

Vector = NDArray[np.float64]
TERM_SIZE = 3


class Harmonic(NamedTuple):
    """`number` in 1/rad | 1/m, `sine` and `cosine` in N m | N."""

    number: float
    sine: float
    cosine: float


class Load(NamedTuple):
    """SI; `stiffness` in N m/rad | N/m. The default is no load."""

    stiffness: float = 0.0
    harmonics: tuple[Harmonic, ...] = ()

    def as_array(self) -> Vector:
        """For the kernels: (1 + 3 h,), empty where there is no load."""
        if self == Load():
            return np.empty(0)
        return np.array([self.stiffness, *(value for harmonic in self.harmonics for value in harmonic)], dtype=np.float64)

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
