"""Controllers of every structure and block, and what an axis may show them, drawn by hypothesis:
for arithmetic, not for a loop."""

from __future__ import annotations

import functools
import math

import msgspec
import numpy as np
from hypothesis import strategies as st

from frictool.documents.bench import Winding
from frictool.documents.controller import (
    Controller,
    Corner,
    Feedforward,
    FrictionCompensation,
    Limiter,
    LinearController,
    PositionLaw,
    Prefilter,
    Profile,
    Schedule,
    StateSpace,
    Velocity,
)
from frictool.typing import Matrix
from studies.rigs.example_controllers import clutch_controller

STEP = 2 * math.pi / 56
TRAVEL = 63.0
seeds = st.integers(0, 2**32 - 1)
Sample = tuple[float, float, float]  # reference, position, velocity


@functools.cache
def on_the_clutch() -> Controller:
    return clutch_controller()


def stable(random: np.random.Generator, n: int, radius: float = 0.9) -> Matrix:
    """Any matrix (n, n) of at most this spectral radius."""
    a = random.standard_normal((n, n))
    return a * (radius / max(1.0, float(np.max(np.abs(np.linalg.eigvals(a)))))) if n else a


def space(a: Matrix, b: Matrix, c: Matrix, d: float) -> StateSpace:
    def rows(matrix: Matrix) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(map(float, row)) for row in matrix)

    return StateSpace(rows(a), rows(b.reshape(-1, 1)), rows(c.reshape(1, -1)), ((d,),))


@st.composite
def linear_controllers(draw: st.DrawFn, *, bounded: bool = False) -> LinearController:
    """State space or sections, with and without integrators, anti-windup, conditional integration;
    `bounded`: no state may run away."""
    random = np.random.default_rng(draw(seeds))
    entering = draw(st.sampled_from(["eta", "speed_error"]))
    if draw(st.booleans()):
        return _sections(random, draw(st.integers(1, 3)), entering)
    n = draw(st.integers(0, 4))
    a, b, c, gains = (
        stable(random, n),
        random.standard_normal(n),
        random.standard_normal(n),
        np.zeros(n),
    )
    integrator = n > 0 and draw(st.booleans())
    if integrator:
        a[0], a[0, 0] = 0.0, 1.0
        if bounded:
            a[1:, 0], b[0], c[0] = 0.0, abs(b[0]), abs(c[0])
    conditional = draw(st.booleans()) or (bounded and integrator)
    if not (bounded and integrator) and draw(st.booleans()):
        gains = 0.1 * random.standard_normal(n)
        closed = a - np.outer(gains, c)
        if bounded and n and np.max(np.abs(np.linalg.eigvals(closed))) > 0.97:
            gains = np.zeros(n)
    b[random.random(n) < 0.2] = 0.0
    discrete = space(
        a, b, c, float(random.standard_normal()) * draw(st.sampled_from([0.0, 1.0, 1.0]))
    )
    return LinearController(
        discrete, discrete, (), tuple(map(float, gains)), input=entering, conditional=conditional
    )


def _sections(random: np.random.Generator, count: int, entering: str) -> LinearController:
    rows = []
    for _ in range(count):
        radius, angle = random.uniform(0.0, 0.95), random.uniform(0.0, math.pi)
        rows.append(
            (*random.standard_normal(3), 1.0, -2.0 * radius * math.cos(angle), radius * radius)
        )
    discrete = space(
        np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0
    )  # another form of it, which does not run
    sos = tuple(tuple(map(float, row)) for row in rows)
    gains = tuple(
        float(value)
        for value in 0.01 * random.standard_normal(2 * count) * (random.random(2 * count) < 0.5)
    )
    return LinearController(
        discrete, discrete, sos, (), input=entering, form="sos", sos_anti_windup=gains
    )


def laws(action: st.SearchStrategy[str]) -> st.SearchStrategy[PositionLaw]:
    return st.builds(
        PositionLaw,
        gain=st.floats(1.0, 200.0),
        kind=st.sampled_from(["square_root", "proportional"]),
        band=st.floats(0.1, 5.0),
        action=action,
        settled_speed=st.none() | st.floats(1.0, 50.0),
        rest_speed=st.floats(1.0, 100.0),
    )


limiters = st.builds(
    Limiter,
    condition=st.sampled_from(["energy", "error"]),
    band=st.floats(0.1, 5.0),
    inertia=st.just(1.32e-5),
    coulomb=st.floats(0.01, 0.2),
    virtual_coulomb=st.sampled_from([0.0, 0.1]),
    virtual_speed=st.floats(1.0, 100.0),
    settled_speed=st.none() | st.floats(1.0, 50.0),
)
compensations = st.builds(
    FrictionCompensation,
    source=st.sampled_from(["model", "observer"]),
    velocity=st.sampled_from(["reference", "measured"]),
    coulomb=st.floats(0.0, 0.2),
    viscous=st.floats(0.0, 1e-3),
    smoothing_speed=st.floats(1.0, 100.0),
    observer_rad_s=st.floats(1.0, 500.0),
    inertia=st.just(1.32e-5),
    gain=st.floats(0.1, 1.5),
) | st.builds(
    FrictionCompensation,
    source=st.just("model"),
    velocity=st.sampled_from(["reference", "measured"]),
    smoothing_speed=st.just(2.0),
    speeds=st.just((-80.0, -9.0, -2.0, 2.0, 7.5, 60.0)),
    efforts=st.tuples(*[st.floats(-0.2, 0.2)] * 6),
    gain=st.floats(0.1, 1.5),
)
compensations |= st.builds(
    msgspec.structs.replace,
    compensations.filter(lambda one: one.source == "model"),
    positions=st.just((-20.0, 3.0, 11.0, 60.0)),
    forward=st.tuples(*[st.floats(-0.1, 0.1)] * 4),
    backward=st.just(()) | st.tuples(*[st.floats(-0.1, 0.1)] * 4),
)
velocities = st.builds(
    Velocity,
    source=st.sampled_from(["position", "position", "measured"]),
    order=st.sampled_from([1, 2]),
    bandwidth_rad_s=st.sampled_from([0.0, 150.0, 300.0, 1900.0]),
)
prefilters = st.none() | st.builds(
    Prefilter, natural_frequency_rad_s=st.floats(5.0, 300.0), damping=st.floats(0.5, 1.5)
)
profiles = st.builds(
    Profile,
    speed=st.floats(50.0, 1000.0),
    acceleration=st.floats(500.0, 50_000.0),
    smoothing_samples=st.integers(2, 12),
)
feedforwards = st.none() | st.builds(
    Feedforward,
    inertia=st.just(1.32e-5),
    viscous=st.floats(0.0, 1e-3),
    coulomb=st.floats(0.0, 0.2),
    switch_on_speed=st.floats(5.0, 20.0),
    switch_off_speed=st.floats(0.0, 4.0),
)
windings = st.none() | st.builds(
    Winding, resistance_ohm=st.floats(0.05, 1.0), voltage_v=st.floats(1.0, 24.0)
)


@st.composite
def controllers(draw: st.DrawFn, *, bounded: bool = False, scheduled: bool = True) -> Controller:
    """Any composition of blocks on the clutch's bench. `bounded`: none whose states may run away;
    `scheduled`: some with a schedule."""
    base = on_the_clutch()
    actuator = msgspec.structs.replace(base.bench.actuator, winding=draw(windings))
    linear = draw(linear_controllers(bounded=bounded))
    cascade = draw(st.booleans())
    schedule = (
        draw(st.none() | st.integers(0, 4).flatmap(schedules))
        if scheduled and linear.form == "state_space"
        else None
    )
    prefilter = draw(prefilters)
    profile = draw(profiles) if prefilter is None and draw(st.booleans()) else None
    fed = draw(feedforwards)
    if fed is not None and prefilter is None and profile is None:
        fed = msgspec.structs.replace(fed, filter_rad_s=draw(st.sampled_from([50.0, 400.0])))
    return msgspec.structs.replace(
        base,
        delay_samples=draw(st.integers(0, 2)),
        drive_limit=draw(st.sampled_from([0.5, 50.0])),
        structure="speed_cascade" if cascade else "position",
        position_law=draw(laws(st.sampled_from(["cut", "brake", "none"]))) if cascade else None,
        limiter=None if cascade else draw(st.none() | limiters),
        friction_compensation=draw(st.none() | compensations),
        prefilter=prefilter,
        profile=profile,
        feedforward=fed,
        velocity=draw(velocities),
        linear=linear,
        schedule=schedule,
        bench=msgspec.structs.replace(base.bench, actuator=actuator),
    )


@st.composite
def schedules(draw: st.DrawFn, n: int) -> Schedule:
    """Two or four corners, of which all coefficients differ but some that are 0."""
    random = np.random.default_rng(draw(seeds))
    absent = random.random((n, n)) < 0.3
    both = draw(st.booleans())
    corners = []
    for constant in (12.8e-3, 14.0e-3):
        for coulomb in (0.018, 0.180) if both else (0.099,):
            a = np.where(absent, 0.0, stable(random, n))
            d = float(random.standard_normal())
            discrete = space(a, random.standard_normal(n), random.standard_normal(n), d)
            gains = tuple(map(float, 0.1 * random.standard_normal(n)))
            corners.append(Corner(1.32e-5, 3.81e-4, coulomb, constant, discrete, gains))
    return Schedule(("coulomb", "constant") if both else ("constant",), tuple(corners), 1.0, 0.5, 0)


@st.composite
def wanderings(draw: st.DrawFn, samples: int = 50) -> tuple[float, list[Sample]]:
    """A start, then references held for a while and positions that wander by counts, with rests in
    between."""
    start = STEP * draw(st.integers(0, 400))
    rows, position = [], start
    for _ in range(draw(st.integers(1, 4))):
        reference = draw(
            st.one_of(
                st.floats(0.0, TRAVEL), st.just(position), st.floats(position - 2.0, position + 2.0)
            )
        )
        random, most = np.random.default_rng(draw(seeds)), draw(st.sampled_from([0, 0, 1, 3]))
        for move in random.integers(-most, most + 1, samples):
            position += STEP * float(move)
            rows.append((reference, position, STEP * float(move) / 1e-3))
    return start, rows


@st.composite
def assaults(draw: st.DrawFn, samples: int = 60) -> tuple[float, list[Sample]]:
    """Draw inputs that no axis gives: references from end to end at every sample, positions that
    jump over and beyond their whole interval."""
    random = np.random.default_rng(draw(seeds))
    low, high, top = -0.5 * TRAVEL, 1.5 * TRAVEL, 1600.0
    pools = ([low, high], [low, high, 0.0, TRAVEL], [10.0 * low, 10.0 * high, low, high])
    pool = np.array(draw(st.sampled_from(pools)))
    period = draw(st.sampled_from([1, 1, 2, 7, 30]))
    held = np.repeat(random.choice(pool, (samples // period + 1, 2)), period, axis=0)[:samples]
    if draw(st.booleans()):  # every sample from one end to the other
        held[:, 1] = np.where(np.arange(samples) % 2 == 0, low, high)
    speeds = random.choice([-top, top, 10.0 * top, 0.0], samples)
    return float(random.choice(pool)), [
        (float(r), float(y), float(v)) for (r, y), v in zip(held, speeds, strict=True)
    ]
