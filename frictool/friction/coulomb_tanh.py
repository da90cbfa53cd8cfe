"""Coulomb friction with sign(v) smoothed to tanh(v/v_r) (thesis 2.4.2.1).

v is the velocity and v_r a reference speed. With this approximation a body creeps under any effort.
"""

from __future__ import annotations

import math

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import COULOMB, LawParameter
from frictool.friction.static_kernels import never_sticks, no_band, true_velocity
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

SMOOTHING_VELOCITY = LawParameter(  # v_r
    "smoothing_velocity",
    "m/s",
    exclusive=True,
    simulation_only=True,
    comparison_value=lambda values: values["stribeck_velocity"],
)


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Return the friction F_c tanh(v/v_r) [N | N m] with p = [F_c, v_r].

    `direction` is not used.
    """
    return float(p[0] * math.tanh(v / p[1]))


LAW = Law(
    "coulomb_tanh",
    "Coulomb smoothed by tanh",
    "(2.30), 2.4.2.1",
    (COULOMB, SMOOTHING_VELOCITY),
    StaticKernels(slip_force, never_sticks, no_band, true_velocity),
    approximation=True,
    slip_scales=lambda p: (math.inf, float(p[1])),
)
