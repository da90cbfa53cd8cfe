"""Friction map f of an observer (thesis 6.2), from a model."""

from __future__ import annotations

import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import FrictionMap, Row
from frictool.documents.quantity import Span, si_unit
from frictool.friction.position_polynomial import normalise
from frictool.typing import Vector

KNEES = "viscous friction above a knee speed"


def friction_map(model: Model) -> FrictionMap:
    """Return the friction in slip by direction and position (thesis 4.41, 4.44).

    In each direction, the Coulomb friction is multiplied by the normalised position polynomial. The
    viscous coefficient is the mean of both directions at low speeds. The map includes neither the
    Stribeck curve, nor changes of the viscous coefficient with speed, nor the time at rest, nor
    loads. `left_out` names the omitted effects of a model.
    """
    today, laws = model.parameters, model.laws
    opposite = laws.backward if laws is not None else None
    position = laws.position if laws is not None else None
    levels = (
        today.coulomb.value,
        (opposite.coulomb if opposite and opposite.coulomb else today.coulomb).value,
    )
    viscous = 0.5 * (
        today.viscous.value
        + (opposite.viscous if opposite and opposite.viscous else today.viscous).value
    )
    if position is None:
        travel = model.bench.mechanics.travel or Span(0.0, 1.0, si_unit("position", model.axis))
        return FrictionMap(travel, (levels[0],), (levels[1],), viscous, today.offset.value)
    shape = position.coulomb
    forward, backward = (
        _scaled(powers, position.over, level)
        for powers, level in zip(
            (shape.forward, shape.backward or shape.forward), levels, strict=True
        )
    )
    return FrictionMap(position.over, forward, backward, viscous, today.offset.value)


def left_out(model: Model) -> list[str]:
    """Return the names of the model's effects that the friction map does not include."""
    laws = model.laws
    if laws is None:
        return ["the Stribeck curve"] if model.parameters.stribeck_velocity is not None else []
    backward_viscous = laws.backward.viscous if laws.backward is not None else None
    features = {
        "the Stribeck curve": model.parameters.stribeck_velocity is not None,
        KNEES: bool(laws.regimes),
        "the difference of viscous friction between directions": backward_viscous is not None
        and backward_viscous.value != model.parameters.viscous.value,
        "the load that depends on position": laws.load is not None,
    }
    return [name for name, present in features.items() if present]


def friction_at(friction: FrictionMap, direction: int, x: Vector | float) -> Vector:
    """Return the friction in slip [N m | N] at the positions x [rad | m].

    Outside the travel of the map, the friction at the nearest end is used.
    """
    powers = friction.forward if direction > 0 else friction.backward
    inside = np.clip(x, friction.over.low, friction.over.high)
    return np.asarray(np.maximum(np.polynomial.polynomial.polyval(inside, powers), 0.0))


def _scaled(powers: Row, over: Span, level: float) -> Row:
    return tuple(
        float(value) for value in level * normalise(np.array(powers), over.low, over.high)[0]
    )
