"""Coulomb friction alone (thesis 2.30): F_c sign(v) in slip; at rest the effort, at most F_c."""

from __future__ import annotations

from frictool.friction import coulomb_viscous
from frictool.friction.law import Law, StaticKernels, straight_slip
from frictool.friction.parameter import COULOMB
from frictool.friction.static_kernels import coulomb_breakaway, no_band, true_velocity
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Return the friction [N | N m] against a motion in `direction`."""
    return coulomb_viscous.slip_force(v, direction, p[0], 0.0)


LAW = Law(
    "coulomb",
    "Coulomb",
    "(2.30)",
    (COULOMB,),
    StaticKernels(slip_force, coulomb_breakaway, no_band, true_velocity),
    slip_scales=straight_slip,
    slip_terms=("coulomb",),
)
