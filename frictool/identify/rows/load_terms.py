"""Load terms in addition to the four sliding parameters, and the axis with these loads.

    term        additional effort
    direction   viscous friction that differs between the directions
    spring      stiffness x
    gravity     gravity_sine sin(x) + gravity_cosine cos(x)      rotary: an unbalanced arm
    ripple      ripple_sine sin(n x) + ripple_cosine cos(n x)    n known: poles, slots, teeth;
                ripple_2 to ripple_6 are additional harmonics with other n

The sliding parameters are inertia, viscous friction, Coulomb friction and offset. Coulomb friction
that differs by direction is not a load term, because it cannot be separated from the offset.

A term is added to the model only if it improves the prediction of strokes that the fit did not use
(`structure_selection`, `term_selection`). If the bench declares its terms (`load.terms`), no other
terms are considered.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, Gravity
from frictool.documents.laws import Laws as LawsDocument
from frictool.documents.laws import Load as LoadLaw
from frictool.documents.laws import Ripple as RippleLaw
from frictool.documents.load_terms import MOST_HARMONICS, LoadTerms, Term
from frictool.documents.quantity import Estimate
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.effects import effect_names
from frictool.plant.axis import BACKLASH_BREAKAWAY_RATIO, AxisParameters
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Vector

DIRECTION, SPRING, GRAVITY, RIPPLE = "direction", "spring", "gravity", "ripple"
RIPPLES = (RIPPLE, *(f"{RIPPLE}_{k}" for k in range(2, MOST_HARMONICS + 1)))
HARMONICS = (GRAVITY, *RIPPLES)
TERMS: dict[str, tuple[str, ...]] = {
    DIRECTION: ("viscous_backward",),
    SPRING: ("stiffness",),
    GRAVITY: ("gravity_sine", "gravity_cosine"),
    **{
        term: (term.replace(RIPPLE, "ripple_sine"), term.replace(RIPPLE, "ripple_cosine"))
        for term in RIPPLES
    },
}
# name of each term in `load.terms`
DECLARED: dict[str, Term] = {
    DIRECTION: "viscous_by_direction",
    SPRING: "spring",
    GRAVITY: "gravity",
    **dict.fromkeys(RIPPLES, "ripple"),
}
POSITIVE = ("inertia", "viscous", "coulomb", "viscous_backward", "coulomb_backward")
HALVES = ("coulomb_backward",)  # parameters of one direction; they belong to no load term
ONLY_OFFSET = LoadTerms(("offset",))  # declaration that no load acts except an offset
TOO_FEW_REPETITIONS = "the motion does not repeat often enough to compute the uncertainty"
SMALLEST = 1e-6  # least inertia in a search, relative to its start value
LEAST_SCALE = 0.01  # least scale of a friction relative to the effort that limits it


def names_of(terms: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the sliding parameters, followed by the parameters of `terms`."""
    return SLIDING + tuple(name for term in terms for name in TERMS[term])


def declared_terms(bench: Bench) -> tuple[str, ...]:
    """Return the load terms that the bench declares."""
    named = () if bench.load is None else bench.load.terms
    harmonics = bench.load.ripple.numbers if bench.load and bench.load.ripple else ()
    absent = RIPPLES[len(harmonics) :]
    return tuple(term for term in TERMS if DECLARED[term] in named and term not in absent)


def possible(bench: Bench) -> tuple[str, ...]:
    """Return the load terms that the bench declares.

    If the bench declares none, return all terms of its axis except ripples.
    """
    if bench.load is not None:
        return declared_terms(bench)
    return (DIRECTION, SPRING, GRAVITY) if bench.axis == "rotary" else (DIRECTION, SPRING)


def wave_number(term: str, bench: Bench) -> float:
    """Return the wave number n of a harmonic, 1/rad | 1/m."""
    if term == GRAVITY:
        return 1.0
    assert bench.load is not None
    assert bench.load.ripple is not None
    ripple = bench.load.ripple
    return 2.0 * np.pi * ripple.numbers[RIPPLES.index(term)] / ripple.per.value


def start_of(name: str, known: Mapping[str, float]) -> float:
    """Return the start value of a parameter in a search, SI.

    The value is `known[name]`. If a parameter of backward motion is not in `known`, the value of
    forward motion is used instead. If that value is missing, too, the start value is 0.
    """
    return known.get(name, known.get(name.removesuffix("_backward"), 0.0))


@dataclass(frozen=True)
class MotionSize:
    """Size of a recorded motion.

    - travel: range of positions, rad | m
    - speed: largest speed, rad/s | m/s
    - effort: rms effort, N m | N
    """

    travel: float
    speed: float
    effort: float


def scale_of(name: str, known: Mapping[str, float], motion: MotionSize) -> float:
    """Return the scale of a parameter in a search, SI.

    A change of the parameter by this scale changes the effort about as much as Coulomb or viscous
    friction does. The scale of Coulomb friction is at least LEAST_SCALE times the effort of the
    motion. The scale of viscous friction is at least LEAST_SCALE times the scale of Coulomb
    friction, divided by the largest speed.
    """
    if name == "inertia":
        return known[name]
    coulomb = max(known["coulomb"], LEAST_SCALE * motion.effort)
    if name == "stiffness":
        return coulomb / motion.travel
    if name in ("viscous", "viscous_backward"):
        return max(known["viscous"], LEAST_SCALE * coulomb / motion.speed)
    return coulomb


def axis_and_load(
    values: Mapping[str, float], bench: Bench, record: MotionRecord
) -> tuple[Vector, Vector]:
    """Return the parameter arrays of axis and load for engine/effort_replay.py.

    `values` are the parameters by name, SI. Breakaway and backlash come from bench.yaml.
    """
    coulomb = values["coulomb"]
    mechanics = bench.mechanics
    rested = mechanics.breakaway.value if mechanics.breakaway is not None else 0.0
    backward = None
    if "viscous_backward" in values:
        backward = AxisFrictionLevels(values["viscous_backward"], coulomb, max(rested, coulomb))
    loose = (
        min(mechanics.backlash_coulomb.value, coulomb)
        if mechanics.backlash_coulomb is not None
        else coulomb
    )
    axis = AxisParameters(
        inertia=values["inertia"],
        viscous=values["viscous"],
        coulomb=coulomb,
        breakaway=max(rested, coulomb),
        offset=values["offset"],
        lag=record.effort_lag,
        backlash=mechanics.backlash.value if mechanics.backlash is not None else 0.0,
        backlash_coulomb=loose,
        backlash_breakaway=BACKLASH_BREAKAWAY_RATIO * loose,
        laws=AxisLaws(backward=backward),
    )
    load = PositionLoad(values.get("stiffness", 0.0))
    for term in HARMONICS:
        sine, cosine = TERMS[term]
        if sine in values:
            load = load._replace(
                harmonics=(
                    *load.harmonics,
                    LoadHarmonic(wave_number(term, bench), values[sine], values[cosine]),
                )
            )
    from frictool.engine.effort_replay import replay_parameters  # loads the engine

    return replay_parameters(axis), np.asarray(load.as_array())


def laws_of(identified: Mapping[str, Interval], bench: Bench) -> LawsDocument | None:
    """Return the loads and the friction by direction in `identified` as laws for a model document.

    Return None if `identified` contains only sliding parameters.
    """

    def known(name: str, dimension: str) -> Estimate:
        least = 0.0 if name in POSITIVE else -math.inf
        return identified[name].estimate(dimension, bench.axis, least)

    backward = load = None
    if "viscous_backward" in identified or "coulomb_backward" in identified:
        viscous = known("viscous_backward", "viscous") if "viscous_backward" in identified else None
        backward = Backward(
            viscous,
            known("coulomb_backward", "effort") if "coulomb_backward" in identified else None,
        )
    stiffness = known("stiffness", "stiffness") if "stiffness" in identified else None
    gravity = (
        Gravity(known("gravity_sine", "effort"), known("gravity_cosine", "effort"))
        if "gravity_sine" in identified
        else None
    )
    ripples = list[RippleLaw]()
    if bench.load is not None and bench.load.ripple is not None:
        repeats = bench.load.ripple
        ripples = [
            RippleLaw(cycles, repeats.per, *(known(name, "effort") for name in TERMS[term]))
            for term, cycles in zip(RIPPLES, repeats.numbers, strict=False)
            if TERMS[term][0] in identified
        ]
    if stiffness is not None or gravity is not None or ripples:
        load = LoadLaw(stiffness, gravity, ripples[0] if ripples else None, tuple(ripples[1:]))
    return None if backward is None and load is None else LawsDocument(backward=backward, load=load)


def load_values(laws: LawsDocument | None) -> dict[str, float]:
    """Return the estimates of the load parameters in `laws`, by the names in TERMS, SI."""
    return {name: one.value for name, one in _load_estimates(laws).items()}


def load_intervals(laws: LawsDocument | None) -> dict[str, tuple[float, float]]:
    """Return the intervals of the load parameters in `laws`, by the names in TERMS, SI."""
    return {name: one.interval for name, one in _load_estimates(laws).items()}


def _load_estimates(laws: LawsDocument | None) -> dict[str, Estimate]:
    if laws is None:
        return {}
    load = laws.load or LoadLaw()
    backward = laws.backward
    estimates: dict[str, Estimate | None] = {
        "stiffness": load.stiffness,
        "viscous_backward": None if backward is None else backward.viscous,
    }
    harmonics = [(RIPPLES[k], ripple) for k, ripple in enumerate(load.ripples)]
    for term, harmonic in ((GRAVITY, load.gravity), *harmonics):
        if harmonic is not None:
            estimates |= dict(zip(TERMS[term], (harmonic.sine, harmonic.cosine), strict=True))
    return {name: one for name, one in estimates.items() if one is not None}


def terms_of(laws: LawsDocument | None) -> tuple[str, ...]:
    """Return the load terms that occur in `laws`."""
    estimates = load_values(laws)
    return tuple(term for term, names in TERMS.items() if any(name in estimates for name in names))


def bench_with_terms(bench: Bench, terms: tuple[str, ...]) -> Bench:
    """Return the bench with the load terms `terms`, or unchanged if it already declares load terms.

    Only fits with the same terms have comparable parameters. For example, a single viscous
    coefficient shifts the offset if viscous friction differs by direction.
    """
    if bench.load is not None:
        return bench
    return msgspec.structs.replace(
        bench, load=LoadTerms(("offset", *(DECLARED[term] for term in terms)))
    )


def with_laws(fit: SlidingFit, bench: Bench) -> SlidingFit:
    """Return the fit with the load parameters as laws of the model document.

    A load parameter with an infinite interval is reported as not identified instead.
    """
    sliding = {name: interval for name, interval in fit.parameters.items() if name in SLIDING}
    removed = effect_names()
    loads = {
        name: interval
        for name, interval in fit.parameters.items()
        if name not in sliding and name not in removed
    }
    determined = {
        name: interval for name, interval in loads.items() if np.isfinite(interval.half_width)
    }
    endless = {name: TOO_FEW_REPETITIONS for name in loads if name not in determined}
    determined = {
        name: interval
        for name, interval in determined.items()
        if name in HALVES or not any(other in endless for other in _term(name))
    }
    return replace(
        fit,
        parameters=sliding,
        refused={**fit.refused, **endless},
        laws=laws_of(determined, bench),
        effects={name: one for name, one in fit.parameters.items() if name in removed},
    )


def _term(name: str) -> tuple[str, ...]:
    return next(names for names in TERMS.values() if name in names)
