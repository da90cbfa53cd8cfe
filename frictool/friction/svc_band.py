"""Static, viscous and Coulomb friction that treats speeds up to dv as rest (thesis 2.32).

At such speeds the body sticks, but its position still drifts at up to dv.
"""

from __future__ import annotations

from frictool.friction.law import Law, StaticKernels
from frictool.friction.parameter import BREAKAWAY, COULOMB, VISCOUS, LawParameter
from frictool.friction.static_kernels import breakaway_level, true_velocity
from frictool.friction.svc import slip_force
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

BAND = LawParameter("band", "m/s", exclusive=True)  # dv


@kernel
def band(p: Vector) -> float:
    """Return dv [m/s | rad/s], the speed up to which the body is treated as at rest."""
    return float(p[3])


LAW = Law(
    "svc_band",
    "Static, viscous and Coulomb with a band",
    "(2.32)",
    (COULOMB, BREAKAWAY, VISCOUS, BAND),
    StaticKernels(slip_force, breakaway_level, band, true_velocity),
)
