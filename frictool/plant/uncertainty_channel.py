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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from frictool.documents.model import Model
from frictool.plant.generalised_plant import UncertaintyChannel
from frictool.plant.linear_axis import AxisRates
from frictool.plant.polytope import PARAMETERS, Parameter, PlantPoint, Polytope, intervals, polytope


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


def half_widths(model: Model) -> dict[Parameter, float]:
    """Return the half-width of every parameter's interval."""
    box = intervals(model)
    return {name: 0.5 * (box[name][1] - box[name][0]) for name in PARAMETERS}


def default_unit(model: Model) -> float:
    """Return the half-width of the Coulomb friction [N m or N].

    If it is 0, the unit is the effort of the other uncertainties at the drive's limit.
    """
    widths = half_widths(model)
    if widths["coulomb"] > 0.0:
        return widths["coulomb"]
    actuator, inertia = model.bench.actuator, model.parameters.inertia.value
    at_limit = (
        widths["constant"] + widths["inertia"] * actuator.constant.value / inertia
    ) * actuator.limit.value
    return at_limit if at_limit > 0.0 else 1.0


def uncertain_centre(model: Model, unit: float | None = None) -> UncertainPlant:
    """Return the LFT form (22): the centre of all intervals, all parameters in the channel."""
    return with_channel(polytope(model).centre, half_widths(model), unit or default_unit(model))


def uncertain_polytope(
    model: Model, scheduled: Sequence[Parameter], unit: float | None = None
) -> tuple[Polytope, tuple[UncertainPlant, ...]]:
    """Return the mixed form (28)-(29): the polytope, and each vertex with its channel.

    The polytope spans the scheduled parameters; the others are in the channel. Speed regimes
    contain the viscous and Coulomb friction between them (annex 5.1), so that scheduling regimes
    removes both from the channel. Raises the errors of `polytope`.
    """
    box, left, chosen = (
        polytope(model, scheduled),
        unscheduled_half_widths(model, scheduled),
        unit or default_unit(model),
    )
    return box, tuple(with_channel(point, left, chosen) for point in box.vertices)


def unscheduled_half_widths(model: Model, scheduled: Sequence[Parameter]) -> dict[Parameter, float]:
    """Return the half-widths of the parameters that are not scheduled."""
    covered = {*scheduled, *(("viscous", "coulomb") if "regime" in scheduled else ())}
    return {name: width for name, width in half_widths(model).items() if name not in covered}
