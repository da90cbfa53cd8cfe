"""Polytope of a model's plants, with and without an uncertainty channel.

plant/uncertainty_channel.py defines the channel.
"""

from __future__ import annotations

from collections.abc import Sequence

from frictool.adapters.parameter_intervals import hull, intervals
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.polytope import PARAMETERS, Parameter, Polytope, spanned
from frictool.plant.regime_tangents import RegimeLevels
from frictool.plant.uncertainty_channel import UncertainPlant, with_channel


def polytope(model: Model, scheduled: Sequence[Parameter] = PARAMETERS) -> Polytope:
    """Return the polytope of plants over the intervals of the `scheduled` parameters.

    parameter_intervals.py `intervals` defines the intervals. A parameter that is not scheduled has
    the value in the middle of its interval. Raises FrictoolError if `scheduled` contains `regime`
    and the model has no regimes. Raises ValueError if `scheduled` is empty or contains a parameter
    twice.
    """
    box = intervals(model)
    levels = regime_levels(model, box["coulomb"]) if "regime" in scheduled else None
    return spanned(box, scheduled, levels)


def regime_levels(model: Model, coulomb: tuple[float, float]) -> RegimeLevels:
    """Return the intervals of the friction in each speed regime of the model.

    `coulomb`: interval of the Coulomb friction at low speed.

    Raises FrictoolError if the model has no regimes.
    """
    if model.laws is None or not model.laws.regimes:
        raise FrictoolError(
            "regime: the model has no laws.regimes; schedule viscous and coulomb "
            "instead, or identify from logs over a wider range of speeds"
        ).at("design", "schedule")
    backward = model.laws.backward
    slow = (
        model.parameters.viscous,
        *((backward.viscous,) if backward and backward.viscous else ()),
    )
    fast = [
        (regime.viscous, *((regime.backward,) if regime.backward else ()))
        for regime in model.laws.regimes
    ]
    return RegimeLevels(
        coulomb,
        (0.0, *(regime.above.value for regime in model.laws.regimes)),
        tuple(hull(*slopes) for slopes in (slow, *fast)),
    )


def half_widths(model: Model) -> dict[Parameter, float]:
    """Return the half-width of every parameter's interval."""
    box = intervals(model)
    return {name: 0.5 * (box[name][1] - box[name][0]) for name in PARAMETERS}


def default_unit(model: Model) -> float:
    """Return the effort [N m | N] that corresponds to 1 in the uncertainty channel.

    The effort is the half-width of the Coulomb friction's interval. If this half-width is 0, the
    effort is the error that the half-widths of the drive's constant and of the inertia cause at the
    drive's limit. If this error is also 0, the result is 1.
    """
    widths = half_widths(model)
    if widths["coulomb"] > 0.0:
        return widths["coulomb"]
    actuator = model.bench.actuator
    inertia = model.parameters.inertia.value
    at_limit = (
        widths["constant"] + widths["inertia"] * actuator.constant.value / inertia
    ) * actuator.limit.value
    return at_limit if at_limit > 0.0 else 1.0


def uncertain_centre(model: Model, unit: float | None = None) -> UncertainPlant:
    """Return the central plant in LFT form, with all parameters uncertain (thesis annex, (22))."""
    return with_channel(polytope(model).centre, half_widths(model), unit or default_unit(model))


def uncertain_polytope(
    model: Model, scheduled: Sequence[Parameter], unit: float | None = None
) -> tuple[Polytope, tuple[UncertainPlant, ...]]:
    """Return the polytope, and each of its vertices with an uncertainty channel.

    The polytope spans the scheduled parameters; the channel contains the other parameters (thesis
    annex, (28)-(29)). If `regime` is scheduled, the regimes determine the friction, and the channel
    contains no friction. Raises FrictoolError and ValueError as `polytope` does.
    """
    box = polytope(model, scheduled)
    left = unscheduled_half_widths(model, scheduled)
    chosen = unit or default_unit(model)
    return box, tuple(with_channel(point, left, chosen) for point in box.vertices)


def unscheduled_half_widths(model: Model, scheduled: Sequence[Parameter]) -> dict[Parameter, float]:
    """Return the half-widths of the parameters that are not scheduled."""
    covered = {*scheduled, *(("viscous", "coulomb") if "regime" in scheduled else ())}
    return {name: width for name, width in half_widths(model).items() if name not in covered}
