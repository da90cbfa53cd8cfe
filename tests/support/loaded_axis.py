"""A rotary axis that a known effort drives against friction and one load beside it: truth, log and
bench of a seed; what a fit says."""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from frictool.documents.bench import Bench, Encoder
from frictool.documents.load_terms import LoadTerms, RipplePeriod, Term
from frictool.documents.quantity import Estimate, Quantity
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.identify.fit_result import Interval, SlidingFit
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisFrictionLevels, AxisLaws
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from tests.support.linear_axis import PERIOD, linear_bench

Known = Interval | Estimate
SAMPLES, COUNT, NOISE = (
    20_000,
    2.0 * math.pi / 65536,
    0.3,
)  # rad; N m, standard deviation of the effort's noise
CYCLES = 7.0  # of the ripple in a turn
TERMS: dict[str, tuple[Term, ...]] = {
    "spring": ("offset", "spring"),
    "gravity": ("offset", "gravity"),
    "ripple": ("offset", "ripple"),
    "viscous": ("offset", "viscous_by_direction"),
    "coulomb": ("coulomb_by_direction",),
}
BENCH = f"""\
format: bench/1
name: arm
axis: rotary
sample_period_s: 0.001
encoder: {{counts_per_revolution: {2.0 * math.pi / COUNT:.10g}}}
actuator:
  drive: current
  constant: {{value: 20, unit: N m/A}}
  limit: {{value: 10, unit: A}}
mechanics:
  inertia: {{value: 5, low: 3, high: 7, unit: kg m^2}}
  viscous: {{value: 12, low: 4, high: 20, unit: N m s/rad}}
  coulomb: {{value: 8, low: 3, high: 13, unit: N m}}
columns:
  time: {{column: time, unit: s}}
  position: {{column: encoder, unit: count}}
  effort: {{column: torque, unit: N m}}
"""


@dataclass(frozen=True)
class Loaded:
    """truth: name of each parameter -> its value in SI, those of the load among them."""

    truth: dict[str, float]
    record: MotionRecord
    bench: Bench


def rotary_bench(terms: tuple[Term, ...] | None) -> Bench:
    """The carriage's bench on a rotary axis; `terms` of its load, None where it says nothing."""
    bench = linear_bench()
    ripple = (
        RipplePeriod(CYCLES, Quantity(2.0 * math.pi, unit="rad"))
        if terms and "ripple" in terms
        else None
    )
    load = None if terms is None else LoadTerms(terms, ripple)
    return msgspec.structs.replace(
        bench,
        axis="rotary",
        encoder=Encoder(counts_per_revolution=2.0 * math.pi / COUNT),
        load=load,
    )


def loaded_axis(seed: int, kind: str, known: bool = True, noise: float = NOISE) -> Loaded:
    """The axis of a seed under a load of this kind of TERMS, or none at all where it is '';
    `known`: whether the bench names it."""
    draw, time = np.random.default_rng([seed, 21]), np.arange(SAMPLES) * PERIOD
    truth = {
        "inertia": 5.0 * draw.uniform(0.8, 1.2),
        "viscous": 12.0 * draw.uniform(0.7, 1.3),
        "coulomb": 8.0 * draw.uniform(0.7, 1.3),
        "offset": 0.0 if kind == "coulomb" else draw.uniform(-1.0, 1.0),
    }
    level = truth["coulomb"]
    backward, load = AxisFrictionLevels(truth["viscous"], level, level), PositionLoad()
    one, other = (
        draw.uniform(1.0, 4.0) * draw.choice((-1.0, 1.0)),
        draw.uniform(1.0, 4.0) * draw.choice((-1.0, 1.0)),
    )
    if kind == "spring":
        truth["stiffness"] = 10.0 * abs(one)
        load = PositionLoad(truth["stiffness"])
    elif kind == "gravity":
        truth |= {"gravity_sine": one, "gravity_cosine": other}
        load = PositionLoad(0.0, (LoadHarmonic(1.0, one, other),))
    elif kind == "ripple":
        truth |= {"ripple_sine": 0.2 * one, "ripple_cosine": 0.2 * other}
        load = PositionLoad(0.0, (LoadHarmonic(CYCLES, 0.2 * one, 0.2 * other),))
    elif kind == "viscous":
        truth["viscous_backward"] = truth["viscous"] * draw.uniform(1.1, 1.5)
        backward = backward._replace(viscous=truth["viscous_backward"])
    elif kind == "coulomb":
        truth["coulomb_backward"] = level * draw.uniform(1.1, 1.5)
        backward = AxisFrictionLevels(
            truth["viscous"], truth["coulomb_backward"], truth["coulomb_backward"]
        )
    sliding = {name: truth[name] for name in ("inertia", "viscous", "coulomb", "offset")}
    axis = AxisParameters(**sliding, breakaway=level, laws=AxisLaws(backward=backward))
    swings = ((25.0, 0.9), (18.0, 0.37), (11.0, 0.23))
    effort = sum(a * np.sin(2.0 * np.pi * f * time + draw.uniform(0.0, 6.0)) for a, f in swings)
    x, v = np.empty(SAMPLES), np.empty(SAMPLES)
    assert (
        replay(
            replay_parameters(axis),
            load.as_array(),
            rest(draw.uniform(-0.2, 0.2)),
            effort,
            effort,
            FREE,
            PERIOD,
            x,
            v,
        )
        == 0
    )
    noisy = effort + noise * draw.standard_normal(SAMPLES)
    record = make_record("loaded", time, np.floor(x / COUNT) * COUNT, noisy, COUNT, 0.0)
    return Loaded(truth, record, rotary_bench(TERMS[kind] if known and kind else None))


def estimates(fit: SlidingFit) -> dict[str, Known]:
    """Every parameter that a fit gives, those of its laws among them, by the names of
    `Loaded.truth`."""
    found: dict[str, Known | None] = dict(fit.parameters)
    backward, load = (fit.laws.backward, fit.laws.load) if fit.laws else (None, None)
    if backward is not None:
        found |= {"viscous_backward": backward.viscous, "coulomb_backward": backward.coulomb}
    if load is not None:
        found["stiffness"] = load.stiffness
        for name, harmonic in (("gravity", load.gravity), ("ripple", load.ripple)):
            if harmonic is not None:
                found |= {f"{name}_sine": harmonic.sine, f"{name}_cosine": harmonic.cosine}
    return {name: one for name, one in found.items() if one is not None}


def covered(seed: int, kind: str, method: str) -> dict[str, bool]:
    """Return, for each parameter of `method`, if its interval holds the truth."""
    axis = loaded_axis(seed, kind)
    found = estimates(run(method, [axis.record], axis.bench, IdentificationSettings(0.95)))
    return {name: bool(one.low <= axis.truth[name] <= one.high) for name, one in found.items()}
