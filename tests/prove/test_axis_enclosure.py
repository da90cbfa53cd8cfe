"""Enclosure of the axis: no run of the event-exact engine leaves it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.engine.axis_motion import advance
from frictool.plant import axis as ax
from frictool.plant.axis import AxisParameters
from frictool.prove.axis_enclosure import AT_REST, Ambiguous, AxisSet, advanced, plant_box
from frictool.prove.interval import ZERO, RoundedInterval, decay, point
from frictool.typing import Vector
from studies.rigs.clutch_model import clutch_model

SEED = 20261127
PERIOD = 1e-3
# the engine solves its events to rounding; a stop at 1e4 rad/s^2 turns 1e-12 s into 1e-8 rad/s
ENGINE = 1e-7


def test_sums_and_products_enclose_the_fractions() -> None:
    random = np.random.default_rng(SEED)
    for _ in range(2000):
        a, b = (float(x) for x in random.normal(size=2) * 10.0 ** random.uniform(-9, 9, 2))
        exact = Fraction(a), Fraction(b)
        one, other = point(a), point(b)
        for found, wanted in (
            (one + other, exact[0] + exact[1]),
            (one - other, exact[0] - exact[1]),
            (one * other, exact[0] * exact[1]),
            (one / other, exact[0] / exact[1]),
        ):
            assert Fraction(found.low) <= wanted <= Fraction(found.high)
            assert found.width <= 4.0 * math.ulp(found.magnitude)


def test_products_of_intervals_enclose_their_points() -> None:
    random = np.random.default_rng(SEED)
    for _ in range(500):
        a, b, c, d = (float(x) for x in random.normal(size=4))
        one, other = RoundedInterval(min(a, b), max(a, b)), RoundedInterval(min(c, d), max(c, d))
        product = one * other
        for x in (a, b, 0.5 * (a + b)):
            for y in (c, d, 0.5 * (c + d)):
                assert product.low <= x * y <= product.high


@pytest.mark.parametrize("x", [0.0, 1e-12, 0.3, 0.5, 2.0, 40.0])
def test_decay_encloses_the_exponential(x: float) -> None:
    found = decay(point(x))
    assert found.low <= math.exp(-x) <= found.high
    assert found.width <= 1e-12 * max(math.exp(-x), 1e-300) or x == 40.0


def test_no_run_of_the_engine_leaves_the_enclosure() -> None:
    random = np.random.default_rng(SEED)
    samples = undecided = stops = contacts = 0
    for _ in range(25):
        plant = axis_of(
            clutch_model(),
            inertia=random.uniform(1.11e-5, 1.53e-5),
            viscous=random.choice([0.0, random.uniform(0.0, 7.62e-4)]),
            coulomb=random.uniform(0.018, 0.18),
            constant=random.uniform(0.0128, 0.014),
            offset=random.uniform(-0.01, 0.01),
        ).checked()
        p, box = plant.as_array(), plant_box(plant, PERIOD)
        state, bounds = ax.rest(30.0), AT_REST
        for _ in range(80):
            command = float(random.choice([0.0, random.uniform(-50, 50), random.uniform(-9, 9)]))
            before = bounds
            assert advance(state, command, p, PERIOD) == 0
            try:
                (bounds,) = advanced(bounds, command, box, PERIOD)
            except Ambiguous:
                undecided += 1
                break
            samples += 1
            stops += before.direction != 0 and bounds.direction != before.direction
            contacts += before.edge == 0 and bounds.edge != 0
            assert _contains(bounds, state)
            assert bounds.drive.low - 1e-10 <= state[ax.DRIVE] <= bounds.drive.high + 1e-10
            if abs(state[ax.POSITION] - 30.0) > 25.0:
                break
    assert samples > 600
    assert undecided <= 3
    assert stops > 20
    assert contacts > 10


@pytest.mark.parametrize("room", [1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("speed", [1e-4, 5e-3])
def test_an_axis_that_creeps_to_its_contact_is_enclosed(room: float, speed: float) -> None:
    """The drive accelerates it so much that it would pass the contact many times in one sample."""
    plant = axis_of(clutch_model(), inertia=1.11e-5, viscous=0.0, coulomb=0.018).checked()
    p, box = plant.as_array(), plant_box(plant, PERIOD)
    gap = 0.5 * plant.backlash - room
    drive, command = (plant.backlash_coulomb + plant.offset) / plant.constant, 5.0
    state = ax.rest(30.0, drive)
    state[ax.VELOCITY], state[ax.GAP] = speed, gap
    bounds = AxisSet(ZERO, point(speed), point(drive), point(gap), 1)
    assert advance(state, command, p, PERIOD) == 0
    (bounds,) = advanced(bounds, command, box, PERIOD)
    assert bounds.edge == 1
    assert _contains(bounds, state)
    assert bounds.speed.width < 1e-3 * state[ax.VELOCITY]


COINCIDENCES = [-1e-10, 0.0, 1e-10]  # s, by which an event misses the end of a sample


@pytest.mark.parametrize("shift", COINCIDENCES)
def test_a_contact_at_the_end_of_a_sample_is_enclosed(shift: float) -> None:
    """The speed grows uniformly, so that the contact follows after a time in closed form."""
    inertia, command, period = 2.0**-10, 1.0, 2.0**-10
    distance = 0.5 * command / inertia * (period + shift) ** 2
    plant = AxisParameters(inertia, 0.0, 0.25, 0.25, backlash=2.0 * distance)
    p, box = plant.as_array(), plant_box(plant, period)
    state, bounds = ax.rest(30.0), AT_REST
    for _ in range(2):
        assert advance(state, command, p, period) == 0
        (bounds,) = advanced(bounds, command, box, period)
        assert _contains(bounds, state)
    assert bounds.edge == 1
    assert bounds.moved.width < 1e-6


@pytest.mark.parametrize("shift", COINCIDENCES)
@pytest.mark.parametrize("later", [-0.25, 0.3])
def test_a_stop_at_the_end_of_a_sample_is_enclosed(shift: float, later: float) -> None:
    """A command of -0.25 N m takes the speed that 0.75 N m gave against a friction of 0.25 N m.

    A later command of 0.3 N m lets an axis that moves go on, and one that rests stay at rest.
    """
    period = 2.0**-10
    plant = AxisParameters(2.0**-10, 0.0, 0.25, 0.375)
    p, box = plant.as_array(), plant_box(plant, period)
    state, sets = ax.rest(30.0), (AT_REST,)
    for command, duration in ((0.75, period), (-0.25, period + shift), (later, period)):
        assert advance(state, command, p, duration) == 0
        sets = tuple(new for one in sets for new in advanced(one, command, box, duration))
        assert any(_contains(one, state) for one in sets)
    if shift == 0.0:  # rounding decides
        assert {one.direction for one in sets} == ({0, 1} if later > 0.25 else {0})


def _contains(bounds: AxisSet, state: Vector) -> bool:
    """Return True if the state of the engine, which started at 30 rad, lies in the bounds."""
    moved, speed = state[ax.POSITION] - 30.0, state[ax.VELOCITY]
    return bool(
        bounds.moved.low - ENGINE <= moved <= bounds.moved.high + ENGINE
        and bounds.speed.low - ENGINE <= speed <= bounds.speed.high + ENGINE
        and np.sign(speed) in (0.0, float(bounds.direction))
    )
