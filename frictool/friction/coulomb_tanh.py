"""Coulomb friction with sign(v) smoothed to tanh(v/v_r) (2.4.2.1).

This approximation creeps under any effort.
"""

from __future__ import annotations

import math

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import COULOMB, LawParameter
from frictool.friction.static_kernels import never_sticks, no_band, true_velocity
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

SMOOTHING_VELOCITY = LawParameter("smoothing_velocity", "m/s", "rad/s", exclusive=True)  # v_r


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Return F_c tanh(v/v_r) [N | N m]; `direction` is not used."""
    return float(p[0] * math.tanh(v / p[1]))


@kernel
def slip_slope(v: float, direction: float, p: Vector) -> float:
    """Return the derivative of `slip_force` by v."""
    shape = 1.0 / math.cosh(min(abs(v / p[1]), 400.0))
    return float(p[0] / p[1] * shape * shape)


LAW = Law(
    "coulomb_tanh",
    "Coulomb smoothed by tanh",
    "(2.30), 2.4.2.1",
    (COULOMB, SMOOTHING_VELOCITY),
    StaticKernels(slip_force, slip_slope, never_sticks, no_band, true_velocity),
    approximation=True,
)
