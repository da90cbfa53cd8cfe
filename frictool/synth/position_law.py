"""The square-root law's gain from the model (5.19), annex (5) and annex 5.2, which differ by sqrt 2."""

from __future__ import annotations

import math

from frictool.documents import controller as stored
from frictool.documents.design import PositionLaw
from frictool.documents.model import Model
from frictool.errors import NoSolutionError


def position_law(model: Model, law: PositionLaw) -> stored.PositionLaw:
    """Raises NoSolutionError where the model has no Coulomb friction to brake with."""
    today = model.parameters
    force = today.coulomb.value * law.virtual_coulomb_factor
    gain = math.sqrt((2.0 if law.formula == "sqrt(2F/J)" else 1.0) * force / today.inertia.value)
    if gain <= 0.0:
        raise NoSolutionError("the square-root law needs Coulomb friction: the model's coulomb is zero")
    return stored.PositionLaw(
        gain=gain,
        formula=law.formula,
        band=law.band.value,
        action=law.action,
        settled_speed=law.settled_speed.value,
        rest_speed=0.0 if law.rest_speed is None else law.rest_speed.value,
    )
