"""What the four numbers of a vertex, or of a plant that is drawn, mean for a model that says more
of its friction than two numbers.

coulomb   the mean of F_c over the bench's travel and both directions. Another value multiplies all
          dry friction by one factor: F_c and
          breakaway of both directions, their maps over position, and the friction inside the
          backlash
viscous   the steepest slope over the regimes of speed, the mean of both directions. Another value
          multiplies every slope; knees stay. Where
          the model has no viscous friction at all, the value holds at every speed

So the map keeps its shape, and a vertex with the model's own numbers is the model itself.
"""

from __future__ import annotations

from functools import lru_cache

from frictool.documents.laws import Polynomial
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.friction.position_polynomial import mean_over, normalised_coefficients

Ends = tuple[float, float]


def coulomb_level(model: Model) -> Ends:
    """(low, high) of F_c as above [N m | N]; equal where the model gives no interval."""
    forward, backward = _mean_factors(model)
    own, opposite = model.parameters.coulomb, _opposite(model, "coulomb")
    low, high = (
        0.5 * (forward * a + backward * b)
        for a, b in zip(own.interval, opposite.interval, strict=True)
    )
    return low, high


def coulomb_factor(model: Model, wanted: float) -> float:
    """What all dry friction is multiplied by, so that its level is `wanted`. Raises ValueError
    where there is none to multiply."""
    forward, backward = _mean_factors(model)
    mean = 0.5 * (
        forward * model.parameters.coulomb.value + backward * _opposite(model, "coulomb").value
    )
    if mean > 0.0:
        return wanted / mean
    raise ValueError("coulomb is 0 in both directions; allowed: > 0 where it is varied")


def viscous_level(model: Model) -> Ends:
    """(low, high) of the viscous friction as above [N m s/rad | N s/m]; equal where the model gives
    no interval."""
    steepest = [max(slopes, key=lambda slope: slope.value) for slopes in _slopes(model)]
    low, high = (
        0.5 * sum(ends) for ends in zip(*(slope.interval for slope in steepest), strict=True)
    )
    return low, high


def viscous_factor(model: Model, wanted: float) -> float | None:
    """What every slope is multiplied by, so that the level is `wanted`; None where there is no
    slope to multiply."""
    level = 0.5 * sum(max(slope.value for slope in slopes) for slopes in _slopes(model))
    return wanted / level if level > 0.0 else None


def _slopes(model: Model) -> tuple[list[Quantity], list[Quantity]]:
    """Forward, backward: the viscous friction of every regime of speed."""
    regimes = model.laws.regimes if model.laws is not None else ()
    forward: list[Quantity] = [model.parameters.viscous, *(regime.viscous for regime in regimes)]
    backward: list[Quantity] = [
        _opposite(model, "viscous"),
        *(regime.backward or regime.viscous for regime in regimes),
    ]
    return forward, backward


def _opposite(model: Model, name: str) -> Quantity:
    """The parameter `name` of the negative direction."""
    backward = model.laws.backward if model.laws is not None else None
    own: Quantity | None = getattr(backward, name) if backward is not None else None
    common: Quantity = getattr(model.parameters, name)
    return own or common


def _mean_factors(model: Model) -> Ends:
    """Forward, backward: the mean over the travel of what the map multiplies the Coulomb level of
    the direction by."""
    travel, law = model.bench.mechanics.travel, None if model.laws is None else model.laws.position
    if travel is None or law is None or not travel.low < travel.high:
        return 1.0, 1.0
    ends, curve = (law.over.low, law.over.high), law.coulomb

    def mean(side: Polynomial, backward: bool) -> float:
        powers = (side.backward or side.forward) if backward else side.forward
        return _mean_factor(powers, *ends, travel.low, travel.high)

    return mean(curve, False), mean(curve, True)


@lru_cache(maxsize=64)
def _mean_factor(
    powers: tuple[float, ...], low: float, high: float, first: float, last: float
) -> float:
    """Kept, as it is the same for every plant that is drawn from a model."""
    return mean_over(normalised_coefficients(powers, low, high), low, high, first, last)
