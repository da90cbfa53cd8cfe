"""Parametric uncertainty as one real channel: the LFT form, annex (20)-(23), and the mixed form.

    v' = (K i - sigma_v v - F_c w + w_D)/J          w_D = Delta z_D, |Delta| < 1
    z_D = (dJ sigma_v/J - dsigma_v) v + (dJ F_c/J - dF_c) w + (dK - dJ K/J) i

z_D is of first order in the half-widths dJ, dsigma_v, dF_c, dK. In the mixed form, annex (28)-(29),
a scheduled parameter has the half-width 0 in z_D, and the other terms are computed at each vertex.
The channel may have any unit d [N m or N], with w_D = d w_d and z_d = z_D/d. The unit does not
change Delta, but it changes the norm of the closed loop. The text names no unit; with d equal to
the half-width of the Coulomb friction, the term of the friction has the gain 1.

One Delta moves all parameters together, along the diagonal of their box on which J, sigma_v, F_c
and K grow at once. A bound on this channel therefore proves nothing at the other corners; the loop
is verified there afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from frictool.plant.generalised_plant import UncertaintyChannel
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PARAMETERS, Parameter, PlantPoint


@dataclass(frozen=True)
class UncertainPlant:
    """One plant with its uncertainty channel; `rates.push` is d/J and `unit` is d [N m or N]."""

    point: PlantPoint
    rates: AxisRates
    uncertainty: UncertaintyChannel
    unit: float


def with_channel(
    point: PlantPoint, half_widths: Mapping[Parameter, float], unit: float
) -> UncertainPlant:
    """Return the plant at `point` with the half-widths [SI] of its uncertain parameters.

    A parameter without a half-width is certain. Raises ValueError for a unit that is not positive.
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
