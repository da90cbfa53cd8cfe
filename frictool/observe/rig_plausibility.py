"""Check that the estimates of a log are plausible for the model's rig.

The check uses the inertia, which does not change with wear. The estimated inertia must be in the
range in bench.yaml, widened by the uncertainty of the actuator constant and by the spread between
actuators. An estimate outside this range has three possible reasons:

- the log is from another rig
- the clock or drive of the rig differs from bench.yaml
- the logged drive signal saturates
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.observe.wear.parameter_restriction import INERTIA_SPREAD
from frictool.observe.wear_estimate import EstimateRange, WearEstimate

TRY = "check the log's rig and units, actuator.constant, and the drive's signal for saturation"


def implausible(model: Model, estimate: WearEstimate) -> tuple[str, ...]:
    """Return one line of text for each implausible estimate."""
    inertia = estimate.others.get("inertia")
    odd = [] if inertia is None or estimate.moves == 0 else _inertia(model, inertia, estimate.scale)
    if estimate.moves and estimate.wear.high <= 0.0:
        odd.append(
            "the wear is below 0, which is impossible; check the signs of position and drive"
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
    allowed = f"the ranges of model and bench allow {low:.3g} to {high:.3g}"
    return [
        f"the inertia is {estimate.value:.3g} times the model's inertia, {allowed}: "
        f"do not trust the wear; {TRY}"
    ]
