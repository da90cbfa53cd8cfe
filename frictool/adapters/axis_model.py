"""Axis of a model.yaml as a record for the engine."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from frictool.adapters.friction_levels import coulomb_factor, viscous_factor
from frictool.documents.laws import Laws as LawsDocument
from frictool.documents.laws import Load as LoadDocument
from frictool.documents.laws import Polynomial
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.plant.axis import BACKLASH_BREAKAWAY_RATIO, AxisParameters
from frictool.plant.axis_friction_laws import (
    AxisFrictionLevels,
    AxisLaws,
    FrictionPositionShape,
    Sides,
    ViscousRegime,
)
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Vector

# position [rad | m] that stands for end stops if the axis has none
NEVER = 1e30


def axis_of(model: Model, **overrides: float) -> AxisParameters:
    """Return the model's axis in SI, with end stops at both ends of the bench's travel.

    `overrides`: values of fields of AxisParameters. An overridden Coulomb or viscous friction
        scales the model's friction (adapters/friction_levels.py). An overridden breakaway applies
        to the positive direction; the breakaway of the negative direction is multiplied by the same
        factor.

    If the bench does not state the friction inside the backlash (motor and brushes, thesis 4.4.4),
    this friction is the smaller Coulomb friction of the two directions. Raises ValueError with the
    name of a parameter that is out of range.
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
    dry, slope = _dry(model, overrides), _slope(model, overrides)
    laws = _laws(model, dry, slope)
    if "breakaway" in overrides and laws.backward is not None:
        level = _opposite_breakaway(model, overrides["breakaway"])
        laws = laws._replace(backward=laws.backward._replace(breakaway=level))
    if model.laws is not None:
        values |= {"coulomb": dry * today.coulomb.value, "viscous": slope(today.viscous.value)}
    backward = laws.backward
    ratio = today.breakaway.value / today.coulomb.value if today.coulomb.value > 0.0 else 0.0
    values.setdefault("breakaway", ratio * values["coulomb"] if ratio else today.breakaway.value)
    loose = bench.mechanics.backlash_coulomb
    least = min(values["coulomb"], backward.coulomb if backward else values["coulomb"])
    values.setdefault("backlash_coulomb", min(dry * loose.value, least) if loose else least)
    values.setdefault("backlash_breakaway", BACKLASH_BREAKAWAY_RATIO * values["backlash_coulomb"])
    axis = AxisParameters(**values, laws=laws)
    axis.as_array()  # also checks the laws
    return axis.checked()


def extended_axis(model: Model) -> Vector:
    """Return the model's axis without end stops, as the array of parameters that kernels read."""
    axis = axis_of(model)
    return axis._replace(laws=axis.laws._replace(stops=(-NEVER, NEVER))).as_array()


def _dry(model: Model, overrides: dict[str, float]) -> float:
    if "coulomb" not in overrides or (model.laws is None and model.parameters.coulomb.value == 0.0):
        return 1.0
    return coulomb_factor(model, overrides["coulomb"])


def _slope(model: Model, overrides: dict[str, float]) -> Callable[[float], float]:
    if "viscous" not in overrides:
        return lambda value: value
    wanted = overrides["viscous"]
    factor = viscous_factor(model, overrides["viscous"])
    return (lambda value: wanted) if factor is None else (lambda value: factor * value)


def load_of(model: Model) -> PositionLoad:
    """Return the position-dependent load of the model's axis; `axis_of` leaves this load out."""
    return (
        PositionLoad()
        if model.laws is None or model.laws.load is None
        else load_law(model.laws.load)
    )


def load_law(document: LoadDocument) -> PositionLoad:
    """Return the load terms of a document as a record for the engine."""
    gravity = document.gravity
    harmonics = []
    if gravity is not None:
        harmonics.append(LoadHarmonic(1.0, gravity.sine.value, gravity.cosine.value))
    harmonics += [
        LoadHarmonic(
            2.0 * math.pi * ripple.cycles / ripple.per.value,
            ripple.sine.value,
            ripple.cosine.value,
        )
        for ripple in document.ripples
    ]
    return PositionLoad(
        document.stiffness.value if document.stiffness is not None else 0.0, tuple(harmonics)
    )


def _backward(
    model: Model, dry: float, slope: Callable[[float], float]
) -> AxisFrictionLevels | None:
    backward = model.laws.backward if model.laws else None
    if backward is None:
        return None
    today = model.parameters

    def level(specific: Quantity | None, common: Quantity) -> float:
        return (specific or common).value

    coulomb, breakaway = (
        level(backward.coulomb, today.coulomb),
        level(backward.breakaway, today.breakaway),
    )
    return AxisFrictionLevels(
        slope(level(backward.viscous, today.viscous)), dry * coulomb, dry * breakaway
    )


def _opposite_breakaway(model: Model, forward: float) -> float:
    """Return the backward breakaway [N m | N] of a plant with the given `forward` breakaway."""
    backward = model.laws.backward if model.laws else None
    common = model.parameters.breakaway.value
    if backward is None or backward.breakaway is None or common == 0.0:
        return forward
    return forward * backward.breakaway.value / common


def _laws(model: Model, dry: float, slope: Callable[[float], float]) -> AxisLaws:
    travel = model.bench.mechanics.travel
    velocity = model.parameters.stribeck_velocity
    laws = AxisLaws(
        backward=_backward(model, dry, slope), stribeck_velocity=velocity.value if velocity else 0.0
    )
    if travel is not None:
        laws = laws._replace(stops=(travel.low, travel.high))
    document = model.laws
    if document is None:
        return laws
    slopes = [
        (r.above.value, r.viscous.value, (r.backward or r.viscous).value) for r in document.regimes
    ]
    laws = laws._replace(
        regimes=tuple(
            ViscousRegime(above, slope(forward), slope(backward))
            for above, forward, backward in slopes
        )
    )
    if document.dwell is not None:
        laws = laws._replace(fresh=document.dwell.fresh, rise_time=document.dwell.rise_time_s)
    return laws._replace(
        shape=_shape(document),
        stribeck_exponent=document.stribeck_exponent,
        restitution=document.restitution,
    )


def _shape(document: LawsDocument) -> FrictionPositionShape | None:
    position = document.position
    if position is None:
        return None

    def sides(polynomial: Polynomial) -> Sides:
        return polynomial.forward, polynomial.backward or polynomial.forward

    return FrictionPositionShape(
        position.over.low,
        position.over.high,
        sides(position.coulomb),
        sides(position.breakaway or position.coulomb),
    )
