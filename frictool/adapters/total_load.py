"""Total load of a model: the stated sum of the offset and of all loads over the position."""

from __future__ import annotations

import numpy as np

from frictool.documents.laws import TotalLoad
from frictool.documents.model import Model

POSITIONS = 201  # number of positions at which the stated total is compared with its terms


def valid_total(model: Model) -> TotalLoad | None:
    """Return the total `laws.load.total` of the model; None if it is not valid.

    The total is not valid if the travel in the bench goes beyond the positions of the total. It is
    also not valid if the sum of the model's offset and loads leaves the interval of the total,
    because the user then edited a part of the model.
    """
    load = None if model.laws is None else model.laws.load
    if load is None or load.total is None:
        return None
    from frictool.adapters.axis_model import load_law  # loads numba

    total = load.total
    travel = model.bench.mechanics.travel
    over = travel if total.over is None else total.over
    if over is None:
        return total
    if travel is not None and not over.low <= travel.low < travel.high <= over.high:
        return None
    effort = model.parameters.offset.value + load_law(load).at(
        np.linspace(over.low, over.high, POSITIONS)
    )
    low, high = total.least.interval[0], total.largest.interval[1]
    return total if low <= np.min(effort) <= np.max(effort) <= high else None
