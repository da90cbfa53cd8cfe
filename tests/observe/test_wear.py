"""Wear from logs: the second test of 6.3.2 on some seeds, friction that changes, and actuators that
are not the clutch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_model import load_of
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate as Known
from frictool.documents.registry import load
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator, prior
from frictool.observe.wear_estimate import WearEstimate
from frictool.typing import Vector
from studies.observers.wear_runs import LOOPS, WEARS, Runs, drawn, estimates
from studies.rigs.clutch_fleet import Loop, Unit, believed, clutch, run, steps, targets

ROOT = Path(__file__).parents[2]
SEEDS = range(300, 304)


def taken(model: Model, piece: MotionBlock) -> list[WearEstimate]:
    estimator = WearEstimator(model)
    return [*estimator.take(piece), *estimator.finish()]


@pytest.mark.parametrize("loop", [pytest.param("linear", marks=pytest.mark.accept), "speed"])
def test_second_test_on_some_seeds(loop: Loop) -> None:
    runs = Runs()
    for seed in SEEDS:
        unit = drawn(seed)
        runs.take(estimates(unit, seed, loop), unit.wear)
        runs.take(estimates(Unit(wear=WEARS[seed % 3]), seed, loop, random=True), WEARS[seed % 3])
    figures = runs.figures
    assert figures["largest_percent"] <= 1.5
    assert figures["largest_after_8_percent"] <= 4.0
    assert figures["covered"] >= 0.75
    assert 0.1 < figures["half_percent"] < 0.8


def test_viscous_friction_that_the_model_has_not_is_told_from_wear() -> None:
    unit = Unit(wear=1.2, plain_viscous=2e-4)
    found = taken(believed(), run(unit, targets(5), 5, "speed").pieces[0])
    assert found[-1].wear.value == pytest.approx(1.2, rel=0.02)


@pytest.mark.parametrize("loop", LOOPS)
def test_friction_that_changes_at_once_is_followed_within_two_moves(loop: Loop) -> None:
    found = taken(believed(), run(Unit(wear=1.5, since=5.0), steps(8.0), 1, loop).pieces[0])
    before = [one for one in found if one.time < 5.0]
    after = [one for one in found if one.time > 5.0]
    assert before[-1].wear.low <= 1.0 <= before[-1].wear.high
    assert before[-1].wear.high < 1.1
    assert after[1].wear.value == pytest.approx(1.5, rel=0.03)
    assert after[-1].wear.low <= 1.5 <= after[-1].wear.high


def test_most_intervals_hold_wear_that_goes_on_fast_and_no_estimate_is_far_behind() -> None:
    estimator, held = WearEstimator(clutch()), []
    for part in range(20):
        wear = 1.0 + 0.025 * part  # 25 % in 20 moves
        found = estimator.take(
            run(Unit(wear=wear), targets(100 + part, 1.0), 100 + part, "speed").pieces[0]
        )
        held += [one.wear.low <= wear <= one.wear.high for one in found]
        assert all(abs(one.wear.value / wear - 1.0) < 0.1 for one in found)
    assert len(held) >= 36
    assert np.mean(held) >= 0.7


def test_before_any_move_it_is_what_the_model_says() -> None:
    first = WearEstimator(clutch()).estimate
    assert (first.moves, first.wear.value) == (0, 1.0)
    assert (first.wear.low, first.wear.high) == pytest.approx(
        (0.018 / 0.099, 0.18 / 0.099)
    )  # the bench's range
    sure = msgspec.structs.replace(clutch().parameters.coulomb, low=0.11, high=0.13)
    own = msgspec.structs.replace(
        clutch(), parameters=msgspec.structs.replace(clutch().parameters, coulomb=sure)
    )
    assert (
        prior(own) == first.wear
    )  # of the day on which it was identified: friction has worn since
    mechanics = msgspec.structs.replace(
        own.bench.mechanics,
        coulomb=msgspec.structs.replace(own.bench.mechanics.coulomb, low=None, high=None),
    )
    unknown = msgspec.structs.replace(
        own, bench=msgspec.structs.replace(own.bench, mechanics=mechanics)
    )
    assert prior(unknown).low == pytest.approx(0.11 / 0.12192)


def test_rest_tells_nothing() -> None:
    estimator, time = WearEstimator(clutch()), 1e-3 * np.arange(5000)
    assert estimator.take(MotionBlock(time, np.full(5000, 20.0), np.full(5000, 0.05), False)) == []
    assert estimator.finish() == []
    assert estimator.estimate.moves == 0


def exact(
    model: Model,
    wear: float,
    period: float,
    seconds: float,
    inertia: float = 1.0,
    pace: float = 1.0,
) -> MotionBlock:
    """A log of sines over the travel whose effort follows from the model by the equation of motion;
    friction times `wear`, speeds times `pace`."""
    time: Vector = period * np.arange(round(seconds / period))
    mechanics, today = model.bench.mechanics, model.parameters
    assert mechanics.travel is not None
    assert mechanics.top_speed is not None
    middle, reach = (
        0.5 * (mechanics.travel.low + mechanics.travel.high),
        0.4 * (mechanics.travel.high - mechanics.travel.low),
    )
    rates = pace * mechanics.top_speed.value / reach * np.array([0.5, 0.31])
    parts = [(0.7 * reach, rates[0]), (0.3 * reach, rates[1])]
    x = middle + sum(a * np.sin(w * time) for a, w in parts)
    v = sum(a * w * np.cos(w * time) for a, w in parts)
    acceleration = sum(-a * w**2 * np.sin(w * time) for a, w in parts)
    dry = today.coulomb.value * np.ones(time.size)
    if today.stribeck_velocity is not None:
        dry += (today.breakaway.value - today.coulomb.value) * np.exp(
            -((v / today.stribeck_velocity.value) ** 2)
        )
    effort = (
        inertia * today.inertia.value * acceleration
        + today.viscous.value * v
        + wear * dry * np.sign(v)
    )
    effort += today.offset.value + load_of(model).at(x)
    step = model.bench.encoder.resolution
    return MotionBlock(time, np.floor(x / step) * step, effort, False)


def slow_drive(model: Model) -> Model:
    """With a lag of the drive, so that a logged effort is a measured one and not held."""
    actuator = msgspec.structs.replace(model.bench.actuator, loop_time_constant_s=0.1)
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, actuator=actuator)
    )


@pytest.mark.parametrize("period", [1e-3, 5e-4])
def test_a_linear_axis_without_backlash(period: float) -> None:
    model = slow_drive(load(ROOT / "configs" / "emps" / "published.yaml", Model))
    log = exact(model, 1.3, period, 8.0, inertia=1.15)
    estimator = WearEstimator(model, period)
    found = [*estimator.take(log), *estimator.finish()][-1]
    assert found.wear.value == pytest.approx(1.3, rel=5e-3)
    assert found.others["inertia"].value == pytest.approx(1.15, rel=5e-3)


def test_friction_that_falls_with_speed_is_no_wear() -> None:
    """The model contains the fall, or lacks it: the wear multiplies the Coulomb friction."""
    model = slow_drive(load(ROOT / "configs" / "mass" / "model.yaml", Model))
    fall = Known(0.3, unit="m/s", source="identified")
    breakaway = msgspec.structs.replace(model.parameters.breakaway, value=1.5)
    parameters = msgspec.structs.replace(model.parameters, breakaway=breakaway)
    flat = msgspec.structs.replace(model, parameters=parameters)
    parameters = msgspec.structs.replace(parameters, stribeck_velocity=fall)
    falling = msgspec.structs.replace(model, law="stribeck", parameters=parameters)
    log = exact(falling, 1.2, 1e-3, 12.0)
    for believed_model, warns in ((falling, False), (flat, True)):
        estimator = WearEstimator(believed_model)
        found = [*estimator.take(log), *estimator.finish()][-1]
        assert found.wear.low <= 1.2 <= found.wear.high
        assert found.wear.high - found.wear.low < 0.3
        assert bool(found.warnings) == warns
        assert all("friction falls by" in line and len(line) <= 190 for line in found.warnings)


@pytest.mark.parametrize("pace", [1.0, 0.1])
def test_an_inertia_whose_effort_is_small_beside_friction_is_not_determined(pace: float) -> None:
    """The friction exceeds that of the model by up to 1 % while the axis gains speed."""
    model = slow_drive(load(ROOT / "configs" / "emps" / "published.yaml", Model))
    period = 1e-3 / pace
    log = exact(model, 1.0, period, 8.0 / pace, 1.15, pace)
    acceleration = np.gradient(np.gradient(log.position, period), period)
    smooth = np.convolve(acceleration, np.full(51, 1.0 / 51.0), "same")
    friction = 0.01 * model.parameters.coulomb.value
    skewed = replace(log, effort=log.effort + friction * np.tanh(smooth / np.std(smooth)))
    estimator = WearEstimator(model, period)
    found = [*estimator.take(skewed), *estimator.finish()][-1]
    inertia = found.others["inertia"]
    assert inertia.low <= 1.15 <= inertia.high
    assert inertia.value != pytest.approx(1.15, rel=0.01)
    assert found.undetermined == (() if pace == 1.0 else ("inertia",))
    assert set(found.as_json()["others"]) == {"inertia"} - set(found.undetermined)
