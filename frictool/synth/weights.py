"""Weights of the speed loop: given in the design, or derived from the specification where the design is silent."""

from __future__ import annotations

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.plant.generalised import SpeedWeights


def speed_weights(model: Model, spec: Spec, design: Design) -> SpeedWeights:
    """W1, W2, W3 of (5.56)-(5.58) and the weights on noise and command.

    M_mod comes from the specification, e_stat from its static error over the travel (both may be given). Raises NoSolutionError where
    neither the design nor the specification tells one of them.
    """
    given, travel = design.weights, model.bench.mechanics.travel
    margin = given.modulus_margin if given.modulus_margin is not None else spec.modulus_margin
    if margin is None:
        raise NoSolutionError(
            "the weight W2 needs a modulus margin: write modulus_margin in the specification, or weights.modulus_margin in the design"
        )
    error = given.static_error
    if error is None and spec.static_error is not None and travel is not None:
        error = min(0.5, spec.static_error.value / (travel.high - travel.low))
    if error is None:
        raise NoSolutionError(
            "the weight W2 needs a relative static error: write static_error in the specification and mechanics.travel in the bench, "
            "or weights.static_error in the design"
        )
    return SpeedWeights.of(given.bandwidth_rad_s, margin, error, given.disturbance, given.drive, given.command, given.noise.value)
