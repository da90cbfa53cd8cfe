"""What may load an axis beside the four sliding parameters, each term with its parameters, and the axis that their values make.

    direction   viscous friction backward differs from that forward; a Coulomb friction that does is one number with the offset
    spring      + stiffness x
    gravity     + gravity_sine sin(x) + gravity_cosine cos(x)          rotary axes: an arm that is not balanced

A term belongs to the model where data that took no part say so (`held_out`), not because it can be fitted.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, Gravity
from frictool.documents.laws import Laws as LawsDocument
from frictool.documents.laws import Load as LoadLaw
from frictool.documents.quantity import Estimate, si_unit
from frictool.engine.replay import replayed
from frictool.identify.outcome import SLIDING, Interval
from frictool.identify.record import Record, Vector
from frictool.plant.axis import BACKLASH_BREAKAWAY_RATIO, AxisParameters
from frictool.plant.axis_laws import Laws, Levels
from frictool.plant.load import Harmonic, Load

DIRECTION, SPRING, GRAVITY = "direction", "spring", "gravity"
TERMS: dict[str, tuple[str, ...]] = {
    DIRECTION: ("viscous_backward",),
    SPRING: ("stiffness",),
    GRAVITY: ("gravity_sine", "gravity_cosine"),
}
POSITIVE = ("inertia", "viscous", "coulomb", "viscous_backward")
SMALLEST = 1e-6  # of its start: no inertia below it is tried


def names_of(terms: tuple[str, ...]) -> tuple[str, ...]:
    """The parameters of a structure, the sliding ones first."""
    return SLIDING + tuple(name for term in terms for name in TERMS[term])


def possible(bench: Bench) -> tuple[str, ...]:
    """The terms that this kind of axis may have."""
    return (DIRECTION, SPRING, GRAVITY) if bench.axis == "rotary" else (DIRECTION, SPRING)


def start_of(name: str, known: Mapping[str, float]) -> float:
    """Where the search for a parameter begins: what is known, backward as forward, no load."""
    return known.get(name, known.get(name.removesuffix("_backward"), 0.0))


def scale_of(name: str, known: Mapping[str, float], travel: float) -> float:
    """The size of a change of a parameter that matters as much as a change of the friction does; `travel` rad | m."""
    if name == "stiffness":
        return known["coulomb"] / travel
    if name in ("inertia", "viscous", "viscous_backward"):
        return known[name.removesuffix("_backward")]
    return known["coulomb"]


def axis_and_load(values: Mapping[str, float], bench: Bench, record: Record) -> tuple[Vector, Vector]:
    """The kernels' arrays of engine/replay.py for SI values of a structure's parameters; what they do not give, the bench does."""
    coulomb, mechanics = values["coulomb"], bench.mechanics
    rested = mechanics.breakaway.value if mechanics.breakaway is not None else 0.0
    backward = None
    if "viscous_backward" in values:
        backward = Levels(values["viscous_backward"], coulomb, max(rested, coulomb))
    loose = min(mechanics.backlash_coulomb.value, coulomb) if mechanics.backlash_coulomb is not None else coulomb
    axis = AxisParameters(
        inertia=values["inertia"],
        viscous=values["viscous"],
        coulomb=coulomb,
        breakaway=max(rested, coulomb),
        offset=values["offset"],
        lag=record.lag,
        backlash=mechanics.backlash.value if mechanics.backlash is not None else 0.0,
        backlash_coulomb=loose,
        backlash_breakaway=BACKLASH_BREAKAWAY_RATIO * loose,
        laws=Laws(backward=backward),
    )
    load = Load(values.get("stiffness", 0.0))
    if "gravity_sine" in values:
        load = load._replace(harmonics=(Harmonic(1.0, values["gravity_sine"], values["gravity_cosine"]),))
    return replayed(axis), np.asarray(load.as_array())


def laws_of(found: Mapping[str, Interval], bench: Bench) -> LawsDocument | None:
    """The `laws` of model.yaml for what was found beyond the sliding parameters; None where there is nothing."""

    def known(name: str, dimension: str) -> Estimate:
        low = max(found[name].low, 0.0) if name in POSITIVE else found[name].low
        return Estimate(found[name].value, low, found[name].high, si_unit(dimension, bench.axis), source="identified")

    backward = load = None
    if "viscous_backward" in found:
        backward = Backward(viscous=known("viscous_backward", "viscous"))
    stiffness = known("stiffness", "stiffness") if "stiffness" in found else None
    gravity = Gravity(known("gravity_sine", "effort"), known("gravity_cosine", "effort")) if "gravity_sine" in found else None
    if stiffness is not None or gravity is not None:
        load = LoadLaw(stiffness, gravity)
    return None if backward is None and load is None else LawsDocument(backward=backward, load=load)
