"""The axis that a model.yaml describes, as the engine takes it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from frictool.documents.laws import Laws as LawsDocument
from frictool.documents.laws import Load as LoadDocument
from frictool.documents.laws import Polynomial
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.friction.position_polynomial import mean_over, normalised
from frictool.plant.axis import BACKLASH_BREAKAWAY_RATIO, AxisParameters
from frictool.plant.axis_laws import Laws, Levels, Regime, Shape, Sides
from frictool.plant.load import Harmonic, Load


def axis_of(model: Model, **overrides: float) -> AxisParameters:
    """The model's axis in SI, its end stops those of the bench's travel; `overrides` replaces fields of AxisParameters.

    A Coulomb friction that is overridden is the mean of the model's over the bench's travel and both directions: one factor on F_c and
    breakaway of both directions, on their map over position and on the friction inside the backlash, so that the map keeps its shape. A
    breakaway that is given too stays as given. A viscous friction that is overridden holds for both directions and at every speed: a
    vertex of the polytope is a bound for the regimes. Friction inside the backlash is a part of the axis's friction (motor and brushes,
    thesis 4.4.4) and never above it; where the bench does not say, it is all of it. Raises ValueError naming what is out of range.
    """
    bench, today = model.bench, model.parameters
    values: dict[str, Any] = {
        "inertia": today.inertia.value,
        "viscous": today.viscous.value,
        "coulomb": today.coulomb.value,
        "offset": today.offset.value,
        "constant": bench.actuator.constant.value,
        "lag": bench.actuator.loop_time_constant_s,
        "drive_limit": bench.actuator.limit.value,
        "backlash": bench.mechanics.backlash.value if bench.mechanics.backlash else 0.0,
        "encoder_step": bench.encoder.resolution,
        "resistance": bench.actuator.winding.resistance_ohm if bench.actuator.winding else 0.0,
        "supply": bench.actuator.winding.voltage_v if bench.actuator.winding else math.inf,
        **overrides,
    }
    backward = _backward(model)
    scale = 1.0
    if "coulomb" in overrides:
        scale = _scale(model, backward, overrides["coulomb"])
        if backward is not None or (model.laws is not None and model.laws.position is not None):
            values["coulomb"] = scale * today.coulomb.value
    if backward is not None:
        backward = backward._replace(coulomb=scale * backward.coulomb, breakaway=scale * backward.breakaway)
    if backward is not None and "viscous" in overrides:
        backward = backward._replace(viscous=overrides["viscous"])
    ratio = today.breakaway.value / today.coulomb.value if today.coulomb.value > 0.0 else 0.0
    values.setdefault("breakaway", ratio * values["coulomb"] if ratio else today.breakaway.value)
    loose, least = bench.mechanics.backlash_coulomb, min(values["coulomb"], backward.coulomb if backward else values["coulomb"])
    values.setdefault("backlash_coulomb", min(scale * loose.value, least) if loose else least)
    values.setdefault("backlash_breakaway", BACKLASH_BREAKAWAY_RATIO * values["backlash_coulomb"])
    axis = AxisParameters(**values, laws=_laws(model, backward, regimes="viscous" not in overrides))
    axis.as_array()  # checks the laws too
    return axis.checked()


def load_of(model: Model) -> Load:
    """What loads the model's axis beside friction; `axis_of` does not hold it."""
    return Load() if model.laws is None or model.laws.load is None else load_law(model.laws.load)


def load_law(document: LoadDocument) -> Load:
    """The same from the document's laws."""
    gravity, ripple, harmonics = document.gravity, document.ripple, []
    if gravity is not None:
        harmonics.append(Harmonic(1.0, gravity.sine.value, gravity.cosine.value))
    if ripple is not None:
        harmonics.append(Harmonic(2.0 * math.pi * ripple.cycles / ripple.per.value, ripple.sine.value, ripple.cosine.value))
    return Load(document.stiffness.value if document.stiffness is not None else 0.0, tuple(harmonics))


def _scale(model: Model, backward: Levels | None, wanted: float) -> float:
    """The factor on all dry friction that makes its mean over the travel and both directions `wanted` [N m | N]."""
    levels = (model.parameters.coulomb.value, backward.coulomb if backward is not None else model.parameters.coulomb.value)
    mean = 0.5 * sum(level * factor for level, factor in zip(levels, _mean_factors(model), strict=True))
    if mean > 0.0:
        return wanted / mean
    if backward is None and model.laws is None:
        return 1.0  # nothing that could be scaled: the friction is the wanted one
    raise ValueError("coulomb is 0 in both directions; allowed: > 0 where it is varied")


def _mean_factors(model: Model) -> tuple[float, float]:
    """Forward, backward: the mean over the travel of what the map multiplies the Coulomb level of the direction by."""
    travel, shape = model.bench.mechanics.travel, None if model.laws is None else _shape(model.laws)
    if travel is None or shape is None or not travel.low < travel.high:
        return 1.0, 1.0
    ends = shape.low, shape.high
    forward, backward = (mean_over(normalised(np.array(b), *ends)[0], *ends, travel.low, travel.high) for b in shape.coulomb)
    return forward, backward


def _backward(model: Model) -> Levels | None:
    """The levels of the negative direction, where the model has its own."""
    given = model.laws.backward if model.laws else None
    if given is None:
        return None
    today = model.parameters

    def level(own: Quantity | None, common: Quantity) -> float:
        return (own or common).value

    return Levels(level(given.viscous, today.viscous), level(given.coulomb, today.coulomb), level(given.breakaway, today.breakaway))


def _laws(model: Model, backward: Levels | None, regimes: bool) -> Laws:
    travel, velocity = model.bench.mechanics.travel, model.parameters.stribeck_velocity
    laws = Laws(backward=backward, stribeck_velocity=velocity.value if velocity else 0.0)
    if travel is not None:
        laws = laws._replace(stops=(travel.low, travel.high))
    document = model.laws
    if document is None:
        return laws
    if regimes:
        laws = laws._replace(
            regimes=tuple(Regime(r.above.value, r.viscous.value, (r.backward or r.viscous).value) for r in document.regimes)
        )
    if document.dwell is not None:
        laws = laws._replace(fresh=document.dwell.fresh, rise_time=document.dwell.rise_time_s)
    return laws._replace(shape=_shape(document), stribeck_exponent=document.stribeck_exponent, restitution=document.restitution)


def _shape(document: LawsDocument) -> Shape | None:
    position = document.position
    if position is None:
        return None

    def sides(polynomial: Polynomial) -> Sides:
        return polynomial.forward, polynomial.backward or polynomial.forward

    return Shape(position.over.low, position.over.high, sides(position.coulomb), sides(position.breakaway or position.coulomb))
