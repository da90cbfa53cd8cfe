"""Made-up controller documents of every composition: both structures, every block on and off,
orders 0 to 8, scheduled or not."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from hypothesis import strategies as st

from frictool.documents.bench import Winding
from frictool.documents.controller import (
    Controller,
    Corner,
    FrictionCompensation,
    Limiter,
    LinearController,
    PositionLaw,
    Prefilter,
    Schedule,
    StateSpace,
    Velocity,
)
from frictool.typing import Matrix
from studies.rigs.example_controllers import clutch_controller

Draw = Any


def space(a: Matrix, b: Matrix, c: Matrix, d: float) -> StateSpace:
    """A document's state space from arrays."""
    rows = tuple(tuple(float(value) for value in row) for row in a)
    column, row = tuple((float(value),) for value in b), tuple(float(value) for value in c)
    return StateSpace(rows, column, (row,), ((d,),))


def stable(
    random: np.random.Generator, n: int, integrates: bool
) -> tuple[Matrix, Matrix, Matrix, float]:
    """A stable random system, its last state an integrator where asked; some of its entries are
    0."""
    a = random.standard_normal((n, n)) * (random.random((n, n)) < 0.8)
    radius = max(np.abs(np.linalg.eigvals(a)), default=0.0)
    a *= random.uniform(0.3, 0.97) / max(radius, 1e-3)
    b, c = random.standard_normal(n), random.standard_normal(n) * (random.random(n) < 0.9)
    if integrates and n:
        a[n - 1] = np.eye(n)[n - 1]
        c[n - 1] = 0.5
    return a, b, c, float(random.choice([0.0, 1.0, -3.7]) if n else 2.5)


@st.composite
def linears(draw: Draw, cascade: bool, form: str) -> LinearController:
    """A linear controller; its continuous form is not what these tests are about."""
    order, random = draw(st.integers(0, 8)), np.random.default_rng(draw(st.integers(0, 2**16)))
    conditional = form == "state_space" and draw(st.booleans())
    a, b, c, d = stable(random, order, conditional)
    gains = tuple(
        float(value) for value in 1e-3 * random.standard_normal(order) * (not conditional)
    )
    sections = _sections(random, draw(st.integers(1, 3))) if form == "sos" else ()
    document = space(a, b, c, d)
    return LinearController(
        discrete=document,
        continuous=document,
        sos=sections,
        anti_windup=gains,
        input=draw(st.sampled_from(["eta", "speed_error"])) if cascade else "eta",
        form=form,
        sos_anti_windup=tuple(
            float(value) for value in 1e-3 * random.standard_normal(2 * len(sections))
        ),
        conditional=conditional,
    )


def _sections(random: np.random.Generator, count: int) -> tuple[tuple[float, ...], ...]:
    found = []
    for _ in range(count):
        radius, angle = random.uniform(0.2, 0.9), random.uniform(0.1, 3.0)
        pole = radius * np.exp(1j * angle)
        numerator = random.standard_normal(3)
        found.append(
            tuple(
                float(value)
                for value in (*numerator, 1.0, *np.real(np.poly([pole, pole.conjugate()]))[1:])
            )
        )
    return tuple(found)


@st.composite
def laws(draw: Draw) -> PositionLaw:
    """Every kind and action."""
    action = draw(st.sampled_from(["none", "cut", "brake"]))
    return PositionLaw(
        gain=draw(st.sampled_from([7.0, 81.1, 160.0])),
        kind=draw(st.sampled_from(["square_root", "proportional"])),
        band=draw(st.sampled_from([1.1, 2.0])),
        action=action,
        settled_speed=draw(st.sampled_from([None, 5.0])),
        rest_speed=40.0 if action == "brake" else 0.0,
    )


@st.composite
def limiters(draw: Draw) -> Limiter | None:
    """The limit-cycle limiter in both conditions, with virtual friction and without, or none."""
    condition = draw(st.sampled_from([None, "energy", "error"]))
    if condition is None:
        return None
    virtual = draw(st.booleans())
    energy = {"inertia": 1.32e-5, "coulomb": 0.099} if condition == "energy" else {}
    return Limiter(
        condition=condition,
        band=0.5,
        virtual_coulomb=0.05 if virtual else 0.0,
        virtual_speed=20.0 if virtual else 0.0,
        settled_speed=draw(st.sampled_from([None, 5.0])),
        **energy,
    )


@st.composite
def compensations(draw: Draw) -> FrictionCompensation | None:
    """From a model, its curve, its friction over position or an observer, or none."""
    source = draw(st.sampled_from([None, "model", "curve", "position", "observer"]))
    if source is None:
        return None
    if source == "observer":
        return FrictionCompensation(
            source="observer", observer_rad_s=60.0, inertia=1.32e-5, gain=0.8
        )
    velocity = draw(st.sampled_from(["reference", "measured"]))
    if source == "curve":
        return FrictionCompensation(
            source="model",
            velocity=velocity,
            smoothing_speed=10.0,
            speeds=(-100.0, -25.0, -10.0, 10.0, 30.0, 90.0),
            efforts=(-0.08, -0.06, -0.09, 0.08, 0.05, 0.06),
        )
    modelled = FrictionCompensation(
        source="model", velocity=velocity, coulomb=0.05, viscous=3e-4, smoothing_speed=15.0
    )
    if source == "model":
        return modelled
    backward = draw(st.sampled_from([(), (0.01, -0.02, 0.03)]))
    return msgspec.structs.replace(
        modelled, positions=(-5.0, 20.0, 60.0), forward=(0.02, -0.03, 0.01), backward=backward
    )


def scheduled(controller: Controller) -> Controller:
    """The controller between two corners of a scheduled constant and two of a friction."""
    base = controller.linear.discrete
    corners = []
    for index, (coulomb, constant) in enumerate(
        ((0.05, 0.011), (0.15, 0.011), (0.05, 0.015), (0.15, 0.015))
    ):
        c = tuple(tuple((1.0 + 0.1 * index) * value for value in row) for row in base.c)
        corners.append(
            Corner(
                1.3e-5,
                3.8e-4,
                coulomb,
                constant,
                msgspec.structs.replace(base, c=c),
                controller.linear.anti_windup,
            )
        )
    return msgspec.structs.replace(
        controller, schedule=Schedule(("coulomb", "constant"), tuple(corners), 1.0, 0.5, 9)
    )


@st.composite
def controllers(draw: Draw, schedules: bool = True) -> Controller:
    """Any composition that a document allows."""
    cascade, form = (
        draw(st.booleans()),
        draw(st.sampled_from(["state_space", "state_space", "sos"])),
    )
    measured = draw(st.booleans())
    bandwidth = draw(st.sampled_from([0.0, 150.0, 900.0]))
    velocity = Velocity(
        "measured" if measured else "position", draw(st.sampled_from([1, 2])), bandwidth
    )
    base = clutch_controller(limit=draw(st.sampled_from([0.7, 50.0])))
    actuator = base.bench.actuator
    if draw(st.booleans()):
        actuator = msgspec.structs.replace(actuator, winding=Winding(0.2, 12.0))
    made = msgspec.structs.replace(
        base,
        structure="speed_cascade" if cascade else "position",
        linear=draw(linears(cascade, form)),
        position_law=draw(laws()) if cascade else None,
        limiter=None if cascade or form == "sos" else draw(limiters()),
        prefilter=draw(st.sampled_from([None, Prefilter(30.0, 0.8), Prefilter(60.0, 0.5)])),
        velocity=velocity,
        friction_compensation=draw(compensations()),
        bench=msgspec.structs.replace(base.bench, actuator=actuator),
    )
    return scheduled(made) if schedules and form == "state_space" and draw(st.booleans()) else made
