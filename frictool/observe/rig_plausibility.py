"""Plausibility check of the estimates of a log against the model's rig.

Estimates of another rig are useless, however narrow their intervals. The check uses the inertia,
because it does not wear. The estimated inertia must be in the bench's range of inertia and actuator
constant, widened by the spread between units. Otherwise the log is of another rig, its clock or
drive is not that of the bench, or its signal saturates.
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.observe.interval_estimate import EstimateRange, WearEstimate
from frictool.observe.wear.parameter_restriction import INERTIA_SPREAD

TRY = (
    "is this the rig of the log, does its drive's signal saturate, "
    "are the units and the constant right?"
)


def implausible(model: Model, estimate: WearEstimate) -> tuple[str, ...]:
    """Return one line for each implausible estimate."""
    inertia = estimate.others.get("inertia")
    odd = [] if inertia is None or estimate.moves == 0 else _inertia(model, inertia, estimate.scale)
    if estimate.moves and estimate.wear.high <= 0.0:
        odd.append(
            "the wear is below 0, which is impossible for dry friction: is the sign of the "
            "position or of the drive reversed?"
        )
    return tuple(odd)


def _inertia(model: Model, estimate: EstimateRange, scale: EstimateRange | None) -> list[str]:
    known = (model.parameters.inertia, model.bench.mechanics.inertia)
    nominal = model.parameters.inertia.value
    low = (
        min(one.interval[0] for one in known) / nominal * (scale.low if scale is not None else 1.0)
    )
    high = (
        max(one.interval[1] for one in known) / nominal * (scale.high if scale is not None else 1.0)
    )
    if estimate.high >= low * (1.0 - INERTIA_SPREAD) and estimate.low <= high * (
        1.0 + INERTIA_SPREAD
    ):
        return []
    allowed = f"the bench and its constant allow {low:.3g} to {high:.3g}"
    return [
        f"the inertia is {estimate.value:.3g} times the model's, {allowed}: do not trust the wear; "
        f"{TRY}"
    ]
