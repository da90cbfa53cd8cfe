"""Weights of the speed loop: given in the design, or derived from the specification where the design is silent."""

from __future__ import annotations

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.plant.generalised import FirstOrder, Weights, template


def speed_weights(model: Model, spec: Spec, design: Design) -> Weights:
    """W1, W2, W3 of (5.56)-(5.58) and the weights on noise and command.

    M_mod comes from the specification, e_stat from its static error over the travel (both may be given).
    Raises FrictoolError (exit 3) where neither the design nor the specification tells one of them.
    """
    given, travel = design.weights, model.bench.mechanics.travel
    margin = given.modulus_margin if given.modulus_margin is not None else spec.modulus_margin
    if margin is None:
        raise FrictoolError(
            "modulus_margin: missing in the specification, and weights.modulus_margin in the design; the weight W2 needs one of them"
        )
    error = given.static_error
    if error is None and spec.static_error is not None and travel is not None:
        error = min(0.5, spec.static_error.value / (travel.high - travel.low))
    if error is None:
        raise FrictoolError(
            "weights.static_error: missing in the design, and static_error in the specification with mechanics.travel in the bench; "
            "the weight W2 needs one or the other"
        )
    return Weights(
        error=template(given.bandwidth_rad_s, margin, error),
        disturbance=given.disturbance,
        drive=given.drive,
        command=given.command,
        noise=FirstOrder(given.noise.value),
    )
