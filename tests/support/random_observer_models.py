"""Random models for switched observers, and the gain of an observer along random mode sequences."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np

from frictool.documents.laws import FrictionOverPosition, Laws, Polynomial
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.quantity import Span
from frictool.documents.registry import load
from frictool.observe.design.mode_matrices import subsystems
from frictool.observe.design.switched_settings import SwitchedObserverSettings

MODEL = Path(__file__).parents[2] / "configs/clutch/nonlinear.yaml"
SEED, COUNT, TRAVEL = 61, 60, 2.0


def random_model(number: int) -> tuple[Model, SwitchedObserverSettings, bool]:
    """A model, what is asked for, and whether of the additive kind."""
    random = np.random.default_rng((SEED, number))
    base = load(MODEL, Model)
    period, inertia = 10.0 ** random.uniform(-4.0, -2.0), 10.0 ** random.uniform(-6.0, 3.0)
    top = 10.0 ** random.uniform(-1.0, 2.5)
    coulomb = (
        inertia * top / 10.0 ** random.uniform(-2.0, 0.5)
    )  # stops the axis from its top speed in 10 ms to 3 s
    viscous = random.uniform(0.0, 0.3) * coulomb / top
    shape = [random_shape(random) for _ in range(2)]
    today, mechanics = base.parameters, base.bench.mechanics
    values = {
        "inertia": inertia,
        "coulomb": coulomb,
        "viscous": viscous,
        "breakaway": 1.1 * coulomb,
    }
    parameters = {
        name: msgspec.structs.replace(getattr(today, name), value=value, low=None, high=None)
        for name, value in values.items()
    }
    assert mechanics.top_speed is not None
    span = Span(0.0, TRAVEL, "rad")
    bench = msgspec.structs.replace(
        base.bench,
        sample_period_s=period,
        mechanics=msgspec.structs.replace(
            mechanics,
            top_speed=msgspec.structs.replace(mechanics.top_speed, value=top),
            travel=span,
        ),
    )
    laws = Laws(position=FrictionOverPosition(span, Polynomial(shape[0], shape[1])))
    model = msgspec.structs.replace(
        base, bench=bench, parameters=msgspec.structs.replace(today, **parameters), laws=laws
    )
    return (
        model,
        SwitchedObserverSettings(intervals=int(random.integers(6, 14))),
        bool(number % 4 == 0),
    )


def random_shape(random: np.random.Generator) -> tuple[float, ...]:
    """Friction of mean 1 that stays between 0.3 and 1.7 over the travel."""
    wave = np.polynomial.Chebyshev(
        [0.0, *random.normal(size=random.integers(0, 5))], domain=[0.0, TRAVEL]
    )
    largest = float(np.max(np.abs(wave(np.linspace(0.0, TRAVEL, 501))))) or 1.0
    return tuple(
        float(v) for v in (1.0 + 0.7 * wave / largest).convert(kind=np.polynomial.Polynomial).coef
    )


def largest_gain(observer: Observer, sequences: int = 16, samples: int = 2000) -> float:
    """The largest |z|/|Delta| over gamma along random allowed sequences with a slow disturbance,
    step by step in SI."""
    switched = observer.switched
    assert switched is not None
    random, modes = np.random.default_rng(SEED), subsystems(observer)
    loops = {
        mode.index: modes[mode.index].a - np.array(mode.gains) @ modes[mode.index].c
        for mode in switched.modes
    }
    after = {i: [j for i_, j in switched.transitions if i_ == i] for i in loops}
    worst = 0.0
    for _ in range(sequences):
        e, now, out, entered = np.zeros(3), 0, 0.0, 0.0
        stay, phase = random.uniform(0.3, 0.999), random.uniform(0.0, 2.0 * math.pi)
        for k in range(samples):
            delta = math.sin(2.0 * math.pi * k / 700.0 + phase) + 0.3 * random.normal()
            out, entered = out + float(np.sum((modes[now].weight @ e) ** 2)), entered + delta**2
            e = loops[now] @ e + modes[now].q[:, 0] * delta
            now = now if random.uniform() < stay else int(random.choice(after[now]))
        worst = max(worst, math.sqrt(out / entered) / switched.gamma)
    return worst
