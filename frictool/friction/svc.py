"""Static, viscous and Coulomb friction (thesis 2.31).

In slip, F = F_c sign(v) + sigma_v v with the Coulomb friction F_c, the viscous coefficient sigma_v
and the velocity v. At rest, F equals the effort up to the breakaway F_s.
"""

from __future__ import annotations

from frictool.friction import coulomb_viscous
from frictool.friction.law import Law, StaticKernels, straight_slip
from frictool.friction.parameter import BREAKAWAY, COULOMB, VISCOUS
from frictool.friction.static_kernels import breakaway_level, no_band, true_velocity
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def slip_force(v: float, direction: float, p: Vector) -> float:
    """Return the friction [N | N m] against a motion in `direction` at the velocity v."""
    return coulomb_viscous.slip_force(v, direction, p[0], p[2])


LAW = Law(
    "svc",
    "Static, viscous and Coulomb",
    "(2.31)",
    (COULOMB, BREAKAWAY, VISCOUS),
    StaticKernels(slip_force, breakaway_level, no_band, true_velocity),
    slip_scales=straight_slip,
    slip_terms=("coulomb", "viscous"),
)
