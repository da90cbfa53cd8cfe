"""Scalar friction levels of a model whose friction depends on direction, speed or position.

A plant (a vertex, or a randomly drawn plant) has one number for Coulomb friction and one for
viscous friction. For the model, these two levels are

    coulomb   mean of F_c over the travel in bench.yaml and both directions
    viscous   slope of the friction in the steepest speed regime, mean of both directions

If the Coulomb level of a plant is c times the model's level, all dry friction is multiplied by c:
F_c and breakaway of both directions at every position, and the friction inside the backlash. If a
plant has another breakaway than the model, the breakaway of both directions is multiplied by the
same factor. If the viscous level is c times the model's level, every slope is multiplied by c; the
speeds at which the slope changes remain. If the model has no viscous friction, the viscous level of
a plant is the slope at every speed. A plant with the levels of the model equals the model.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from frictool.documents.laws import Polynomial
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.friction.polynomial_minimum import minimum
from frictool.friction.position_polynomial import mean_over, normalised_coefficients

Ends = tuple[float, float]
# largest number of iterations; difference of normalised polynomials at which the iterations end
DINKELBACH_STEPS, QUOTIENT_ROUNDING = 50, 1e-12


def coulomb_level(model: Model) -> Ends:
    """Return the interval (low, high) of the Coulomb level [N m | N].

    Without an interval in the model, low equals high.
    """
    forward, backward = _mean_factors(model)
    coulomb = model.parameters.coulomb
    opposite = _opposite(model, "coulomb")
    low, high = (
        0.5 * (forward * a + backward * b)
        for a, b in zip(coulomb.interval, opposite.interval, strict=True)
    )
    return low, high


def coulomb_factor(model: Model, wanted: float) -> float:
    """Return the factor on all dry friction that gives the Coulomb level `wanted` [N m | N].

    Raises ValueError if the model has no dry friction.
    """
    forward, backward = _mean_factors(model)
    mean = 0.5 * (
        forward * model.parameters.coulomb.value + backward * _opposite(model, "coulomb").value
    )
    if mean > 0.0:
        return wanted / mean
    raise ValueError("coulomb is 0 in both directions and cannot be varied; allowed: > 0")


def least_breakaway(model: Model) -> float:
    """Return the smallest forward breakaway [N m | N] that is nowhere below the Coulomb friction.

    The condition applies to every position and to both directions. If the breakaway has no separate
    shape over the position, the result is the forward Coulomb friction.
    """
    today, laws = model.parameters, model.laws
    least: float = today.coulomb.value
    position = None if laws is None else laws.position
    if position is None or position.breakaway is None:
        return least
    ends = (position.over.low, position.over.high)
    slip, rest = position.coulomb, position.breakaway
    sides = (
        (today.coulomb, today.breakaway, slip.forward, rest.forward),
        (
            _opposite(model, "coulomb"),
            _opposite(model, "breakaway"),
            slip.backward or slip.forward,
            rest.backward or rest.forward,
        ),
    )
    for coulomb, breakaway, below, above in sides:
        if breakaway.value > 0.0:
            ratio = _largest_ratio(below, above, *ends)
            least = max(least, today.breakaway.value * ratio * coulomb.value / breakaway.value)
    return least


def viscous_level(model: Model) -> Ends:
    """Return the interval (low, high) of the viscous level [N m s/rad | N s/m].

    Without an interval in the model, low equals high.
    """
    steepest = [max(slopes, key=lambda slope: slope.value) for slopes in _slopes(model)]
    low, high = (
        0.5 * sum(ends) for ends in zip(*(slope.interval for slope in steepest), strict=True)
    )
    return low, high


def viscous_factor(model: Model, wanted: float) -> float | None:
    """Return the factor on all viscous slopes that gives the viscous level `wanted`.

    Return None if all slopes are 0, so that no factor can give another level.
    """
    level = 0.5 * sum(max(slope.value for slope in slopes) for slopes in _slopes(model))
    return wanted / level if level > 0.0 else None


def _slopes(model: Model) -> tuple[list[Quantity], list[Quantity]]:
    regimes = model.laws.regimes if model.laws is not None else ()
    forward: list[Quantity] = [model.parameters.viscous, *(regime.viscous for regime in regimes)]
    backward: list[Quantity] = [
        _opposite(model, "viscous"),
        *(regime.backward or regime.viscous for regime in regimes),
    ]
    return forward, backward


def _opposite(model: Model, name: str) -> Quantity:
    backward = model.laws.backward if model.laws is not None else None
    level: Quantity | None = getattr(backward, name) if backward is not None else None
    common: Quantity = getattr(model.parameters, name)
    return level or common


def _mean_factors(model: Model) -> Ends:
    """Return the mean over the travel of the friction's position factor, (forward, backward)."""
    travel = model.bench.mechanics.travel
    law = None if model.laws is None else model.laws.position
    if travel is None or law is None or not travel.low < travel.high:
        return 1.0, 1.0
    ends, curve = (law.over.low, law.over.high), law.coulomb

    def mean(side: Polynomial, backward: bool) -> float:
        powers = (side.backward or side.forward) if backward else side.forward
        return _mean_factor(powers, *ends, travel.low, travel.high)

    return mean(curve, False), mean(curve, True)


@lru_cache(maxsize=64)
def _largest_ratio(
    below: tuple[float, ...], above: tuple[float, ...], low: float, high: float
) -> float:
    """Return the largest quotient `below`/`above` of two polynomials over [low, high].

    Both polynomials are normalised and positive. The method is Dinkelbach's iteration: the next
    quotient is the quotient at the position where q `above` - `below` is smallest, with the present
    quotient q.
    """
    size = max(len(below), len(above))
    lower, upper = (
        np.pad(normalised_coefficients(one, low, high), (0, size - len(one)))
        for one in (below, above)
    )
    ratio = 0.0
    for _ in range(DINKELBACH_STEPS):
        position, distance = minimum(ratio * upper - lower, low, high)
        if distance >= -QUOTIENT_ROUNDING:
            break
        ratio = float(
            np.polynomial.polynomial.polyval(position, lower)
            / np.polynomial.polynomial.polyval(position, upper)
        )
    return ratio


@lru_cache(maxsize=64)  # all plants drawn from one model have the same mean
def _mean_factor(
    powers: tuple[float, ...], low: float, high: float, first: float, last: float
) -> float:
    return mean_over(normalised_coefficients(powers, low, high), low, high, first, last)
