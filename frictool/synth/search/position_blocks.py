"""Position law, prefilter and speed filter of a cascade, from dimensionless parameters.

    law          gain k of the square-root law: k^2 = 2 braking_share braking
    band         band_share times the largest error at rest, at least one encoder step
    rest         rest_share times the speed of the law at the end of the band
    settled      settled_share times step/response
    prefilter    prefilter_product/response
    velocity     velocity_product/dead time, at most MOST_FILTER/sample period

`band` is the half-width of the rest band, in which the drive is released at rest. If the load may
exceed the breakaway friction, the drive stays on (`action: none`), and `rest` and `settled` have no
effect. `braking`, `step`, `response` and the dead time are scales of design_scales.py; F is the
Coulomb friction, J the inertia. The law is stored as k = sqrt(2 phi F/J) or, if k^2 < 2F/J, as k =
sqrt(phi F/J). phi, its `virtual_coulomb_factor`, is at least 1; a k below sqrt(F/J) is raised.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from frictool.documents.design_blocks import PositionLawDesign, PrefilterDesign, VelocityDesign
from frictool.documents.quantity import Quantity, si_unit
from frictool.synth.search.candidate_family import SearchedParameter, rounded
from frictool.synth.search.design_scales import DesignScales

MOST_FILTER = 1.9  # rad/s times s: bandwidth of the filter times the period
MOST_PREFILTER = 1.0  # rad/s times s: frequency of the prefilter times the period
LINEAR_PART = 0.25  # share of the step, at which a proportional law equals the square-root law

PARAMETERS = (
    SearchedParameter("braking_share", 0.1, 1.1, (0.6, 0.3)),
    SearchedParameter("band_share", 0.2, 0.93, (0.7, 0.8)),
    SearchedParameter("rest_share", 0.03, 1.0, (0.3, 0.1)),
    SearchedParameter("settled_share", 0.02, 1.0, (0.2, 0.17)),
    SearchedParameter("prefilter_product", 4.0, 60.0, (10.0, 8.0)),
    SearchedParameter("damping", 0.6, 1.3, (0.85, 1.0)),
    SearchedParameter("velocity_product", 0.4, 8.0, (2.0, 4.0)),
)


RELEASE = ("rest_share", "settled_share")  # parameters without effect if the drive stays on


def position_law(scales: DesignScales, values: Mapping[str, float]) -> PositionLawDesign:
    """Return the position law; in its rest band, the drive brakes the axis and then becomes 0.

    The drive stays on if it must hold the load. The law is proportional if the model has no Coulomb
    friction.
    """
    bench = scales.bench
    squared = 2.0 * values["braking_share"] * scales.braking
    band = rounded(max(scales.count, values["band_share"] * scales.band))
    while band < scales.count:  # rounding may go below one count
        band = rounded(band * 1.001)
    rest = _rest(scales, values, math.sqrt(squared * band))
    length = Quantity(value=band, unit=si_unit("position", bench.axis))
    if scales.friction <= 0.0:
        gain = math.sqrt(squared / (LINEAR_PART * scales.step))
        return PositionLawDesign(
            kind="proportional",
            gain_per_s=rounded(gain),
            band=length if scales.releases else None,
            **rest,  # type: ignore[arg-type] # keys of one record
        )
    factor = squared / (2.0 * scales.friction)
    strong = factor >= 1.0
    return PositionLawDesign(
        formula="sqrt(2F/J)" if strong else "sqrt(F/J)",
        virtual_coulomb_factor=rounded(factor) if strong else rounded(max(1.0, 2.0 * factor)),
        band=length,
        **rest,  # type: ignore[arg-type] # keys of one record
    )


def _rest(scales: DesignScales, values: Mapping[str, float], edge: float) -> dict[str, object]:
    """Return the keys of the position law for the action at rest.

    edge: speed of the law at the end of the band [rad/s | m/s].
    """
    if not scales.releases:
        return {"action": "none"}
    settled = values["settled_share"] * scales.step / scales.response
    unit = si_unit("velocity", scales.bench.axis)
    return {
        "action": "brake",
        "settled_speed": Quantity(value=rounded(settled), unit=unit),
        "rest_speed": Quantity(value=rounded(values["rest_share"] * edge), unit=unit),
    }


def prefilter(scales: DesignScales, values: Mapping[str, float]) -> PrefilterDesign:
    """Return the prefilter of the position reference for the dimensionless parameters `values`."""
    frequency = min(values["prefilter_product"] / scales.response, MOST_PREFILTER / scales.period)
    return PrefilterDesign(
        natural_frequency_rad_s=rounded(frequency), damping=rounded(values["damping"])
    )


def fastest_filter(scales: DesignScales) -> float:
    """Return the largest bandwidth of the speed filter [rad/s] that a search may choose."""
    return _filter(scales, next(one for one in PARAMETERS if one.name == "velocity_product").high)


def _filter(scales: DesignScales, product: float) -> float:
    return min(product / scales.dead_time, MOST_FILTER / scales.period)


def velocity(scales: DesignScales, values: Mapping[str, float]) -> VelocityDesign:
    """Return the low-pass of the encoder's speed for the dimensionless parameters `values`."""
    bandwidth = _filter(scales, values["velocity_product"])
    return VelocityDesign(order=1, filter_rad_s=rounded(bandwidth))
