"""Position law that computes the speed reference: square-root or proportional.

The gain of the square-root law comes from the model: (5.19), annex (5) or annex 5.2, which differ
by sqrt 2. The gain of the proportional law comes from the design.
"""

from __future__ import annotations

import math

from frictool.documents import controller as stored
from frictool.documents.design_blocks import PositionLawDesign
from frictool.documents.model import Model
from frictool.errors import NoSolutionError
from frictool.synth.weights import DerivedValue


def position_law(
    model: Model, law: PositionLawDesign
) -> tuple[stored.PositionLaw, tuple[DerivedValue, ...]]:
    """Return the position law and its derived values.

    Raises NoSolutionError if the square-root law has no Coulomb friction to brake with.
    """
    band, derived = 0.0 if law.band is None else law.band.value, []
    if law.band is None and (law.kind == "square_root" or law.action != "none"):
        band = model.bench.encoder.resolution
        derived.append(
            DerivedValue(
                "position_law.band",
                band,
                "rad" if model.axis == "rotary" else "m",
                "the encoder's step",
            )
        )
    found = stored.PositionLaw(
        gain=_gain(model, law),
        kind=law.kind,
        formula=law.formula,
        band=band,
        action=law.action,
        settled_speed=None if law.settled_speed is None else law.settled_speed.value,
        rest_speed=0.0 if law.rest_speed is None else law.rest_speed.value,
    )
    return found, tuple(derived)


def _gain(model: Model, law: PositionLawDesign) -> float:
    if law.gain_per_s is not None:
        return law.gain_per_s
    today = model.parameters
    force = today.coulomb.value * law.virtual_coulomb_factor
    gain = math.sqrt((2.0 if law.formula == "sqrt(2F/J)" else 1.0) * force / today.inertia.value)
    if gain <= 0.0:
        raise NoSolutionError(
            "the square-root law needs Coulomb friction: the model's coulomb is zero"
        )
    return gain
