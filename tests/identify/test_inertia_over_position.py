"""Inertia, viscous and Coulomb friction from strokes if ramps show friction over position."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity, Span
from frictool.identify.axis_logs import AxisLogs, sort_logs
from frictool.identify.breakaway.breakaway import Breakaway, BreakawayOverPosition
from frictool.identify.breakaway.stribeck_velocity import StribeckVelocityRange
from frictool.identify.breakaway_parameters import with_varying_breakaway
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.fit_warnings import local_ramp_warnings
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.outcome import Outcome
from frictool.identify.sliding_parameters import settled, sliding_fit
from studies.promises.rigs import benches

PERIOD, STEP = 1e-3, 1e-6  # s, m
INERTIA, VISCOUS, COULOMB = 8.0, 60.0, 40.0  # SI
REACH = 0.02  # m, half of a stroke's length
DURATIONS = 0.12, 0.25, 0.4  # s, of one stroke
MOST = 190  # characters of a message


def bench() -> Bench:
    """Return a linear bench with ranges of +-40 % around other values than the true ones."""

    def around(value: float, unit: str) -> Quantity:
        return Quantity(1.1 * value, 0.6 * value, 1.6 * value, unit)

    belt = next(one for one in benches() if one.name == "belt")
    mechanics = structs.replace(
        belt.mechanics,
        inertia=around(INERTIA, "kg"),
        viscous=around(VISCOUS, "N s/m"),
        coulomb=around(COULOMB, "N"),
        travel=Span(-0.05, 0.05, "m"),
    )
    encoder = structs.replace(belt.encoder, step=Quantity(STEP, unit="m"))
    return structs.replace(belt, encoder=encoder, mechanics=mechanics)


def strokes(slope: float, seed: int) -> MotionRecord:
    """Return half-sine strokes over the same positions, with Coulomb friction (1 + slope x)."""
    draw = np.random.default_rng(seed)
    parts = []
    for number in range(36):
        duration = DURATIONS[number // 2 % len(DURATIONS)]
        time = np.arange(round(duration / PERIOD)) * PERIOD
        rate, side = np.pi / duration, 1.0 - 2.0 * (number % 2)
        position = -side * REACH * np.cos(rate * time)
        velocity = side * REACH * rate * np.sin(rate * time)
        acceleration = -(rate**2) * position
        friction = COULOMB * (1.0 + slope * position) * np.sign(velocity)
        parts.append((position, INERTIA * acceleration + VISCOUS * velocity + friction))
    position, effort = (np.concatenate(one) for one in zip(*parts, strict=True))
    effort = effort + 0.3 * draw.standard_normal(effort.size)
    # the drive holds the effort of a row until the next row
    effort = 0.5 * (effort + np.append(effort[1:], effort[-1]))
    time = np.arange(position.size) * PERIOD
    counts = np.floor(position / STEP + draw.uniform()) * STEP
    return make_record("strokes", time, counts, effort, STEP, 0.0)


def ramps(slope: float, reach: float = REACH) -> Breakaway:
    """Return a breakaway of 1.25 times the Coulomb friction at positions up to `reach` [m]."""
    level = 1.25 * COULOMB
    powers = (level, level * slope)
    sure = Interval.around(level, 0.3)
    ends = tuple(Interval.around(one, 0.05 * abs(one)) for one in powers)
    law = BreakawayOverPosition(
        -1.01 * reach, 1.01 * reach, sure, sure, (powers, powers), (ends, ends), common=True
    )
    position = np.linspace(-reach, reach, 20)
    return Breakaway(
        sure, level, level, 20, 0.0, position, np.ones(20), np.full(20, level),
        StribeckVelocityRange(0.0, (0.0, 0.0)), law,
    )  # fmt: skip


@functools.cache
def logs_of(slope: float, seed: int, method: str) -> AxisLogs:
    return sort_logs([strokes(slope, seed)], [], bench(), method, IdentificationSettings())


def outcome_of(logs: AxisLogs, ramp: Breakaway) -> Outcome:
    return with_varying_breakaway(logs, replace(settled(logs, sliding_fit(logs))[0], ramp=ramp))


@pytest.fixture(autouse=True)
def no_map(monkeypatch: pytest.MonkeyPatch) -> None:
    """Refuse every friction map, because the ramps of these tests have no records."""

    def refuse(*_: object) -> None:
        raise UnusableLogs("no records of ramps")

    monkeypatch.setattr("frictool.identify.breakaway_parameters.friction_map", refuse)


@pytest.mark.parametrize("slope", [4.0, -6.0])
def test_strokes_over_the_same_positions_separate_inertia_from_friction(slope: float) -> None:
    """Acceleration is the same function of the position in both directions; friction is not."""
    found = outcome_of(logs_of(slope, 1, "least-squares"), ramps(slope)).identified
    for name, true in (("inertia", INERTIA), ("viscous", VISCOUS), ("coulomb", COULOMB)):
        assert found[name].low <= true <= found[name].high, name
    assert found["inertia"].half_width < 0.05 * INERTIA


def test_a_method_without_friction_over_position_is_named_with_the_alternative() -> None:
    refused = outcome_of(logs_of(4.0, 2, "total-least-squares"), ramps(4.0)).refused["inertia"]
    assert "total-least-squares does not separate them" in refused
    assert refused.endswith("use --method auto")
    assert len(refused) <= MOST


def test_ramps_over_a_small_part_of_the_strokes_give_no_map() -> None:
    """Beyond the ramps, the shape of the friction is unknown; the strokes show it themselves."""
    logs, local = logs_of(4.0, 1, "least-squares"), ramps(4.0, 0.3 * REACH)
    outcome = outcome_of(logs, local)
    assert outcome.identified["inertia"].low <= INERTIA <= outcome.identified["inertia"].high
    assert outcome.laws is not None
    assert outcome.laws.position is not None
    (warning,) = local_ramp_warnings(local, outcome.fit, logs.sliding, logs.bench)
    assert "no friction map is fitted" in warning
    assert len(warning) <= MOST
