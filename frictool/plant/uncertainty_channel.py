"""Parametric uncertainty as one real channel (LFT), annex (20)-(23), (28)-(29).

    v' = (K i - sigma_v v - F_c w + w_D)/J          w_D = Delta z_D, |Delta| < 1
    z_D = (dJ sigma_v/J - dsigma_v) v + (dJ F_c/J - dF_c) w + (dK - dJ K/J) i

J is the inertia, K the actuator's constant, i the drive, sigma_v the viscous friction, v the speed,
F_c the Coulomb friction, and w in [-1, 1] the direction of the friction.

z_D is of first order in the half widths dJ, dsigma_v, dF_c, dK. If some parameters are scheduled
(mixed form, annex (28)-(29)), their half widths in z_D are 0, and z_D is computed at each vertex.
The channel may have any unit d [N m or N], with w_D = d w_d and z_d = z_D/d. The unit does not
change Delta, but it changes the norm of the closed loop. The thesis names no unit; if d is the
half width of the Coulomb friction, the friction term has the gain 1.

One Delta varies all parameters together: J, sigma_v, F_c and K increase or decrease together, along
one diagonal of their box. A bound on this channel proves nothing at the other corners; the loop is
verified there separately.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from frictool.plant.generalised_plant import UncertaintyChannel
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PARAMETERS, Parameter, PlantPoint


@dataclass(frozen=True)
class UncertainPlant:
    """Plant with an uncertainty channel.

    unit: effort d per unit of the channel's signal w_d [N m or N]. The rate `rates.push` is d
    divided by the inertia.
    """

    point: PlantPoint
    rates: AxisRates
    uncertainty: UncertaintyChannel
    unit: float


def with_channel(
    point: PlantPoint, half_widths: Mapping[Parameter, float], unit: float
) -> UncertainPlant:
    """Return the plant at `point` with an uncertainty channel.

    half_widths: half width [SI] of each uncertain parameter; the other parameters are exact. Raises
    ValueError for a unit that is not positive.
    """
    if not unit > 0.0:
        raise ValueError(f"the unit of the uncertainty channel: found {unit:g}; allowed: > 0")
    d_inertia, d_viscous, d_coulomb, d_constant = (
        half_widths.get(name, 0.0) for name in PARAMETERS
    )
    exact = point.rates
    channel = UncertaintyChannel(
        drive=(d_constant - d_inertia * exact.drive) / unit,
        viscous=(d_inertia * exact.viscous - d_viscous) / unit,
        friction=(d_inertia * exact.friction - d_coulomb) / unit,
    )
    return UncertainPlant(point, replace(exact, push=unit / point.inertia), channel, unit)
