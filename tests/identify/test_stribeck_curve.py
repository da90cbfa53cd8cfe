"""The Stribeck curve (2.34) from runs at constant speeds of a simulated axis, under its servo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy
from msgspec import structs

from frictool.adapters.axis_model import axis_of
from frictool.documents.bench import Bench
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.identify.estimators.auto import auto
from frictool.identify.estimators.stribeck_curve import ConstantSpeedRuns, find_runs, stribeck_curve
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.model_document import model_of
from frictool.identify.motion_record import MotionRecord, make_record
from studies.rigs.curve_logs import RUN_SPEEDS, STRIBECK_VELOCITY, constant_speeds, stribeck_axis
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import sines


def test_the_curve_of_the_simulated_axis() -> None:
    truth = stribeck_axis()
    fit = stribeck_curve([constant_speeds(1, truth)], clutch(), IdentificationSettings())
    for name in ("coulomb", "viscous", "offset", "breakaway"):
        assert fit.parameters[name].low <= getattr(truth, name) <= fit.parameters[name].high
    velocity = fit.parameters["stribeck_velocity"]
    assert velocity.low <= STRIBECK_VELOCITY <= velocity.high
    assert velocity.half_width < 0.1 * STRIBECK_VELOCITY
    assert fit.details["exponent"] == 2.0


def test_runs_lie_at_the_speeds_that_were_asked_for() -> None:
    speeds = find_runs([constant_speeds(2, stribeck_axis())]).speed
    assert np.min(np.abs(speeds[:, None] / np.array(RUN_SPEEDS) - 1.0), axis=1).max() < 0.02


def test_friction_that_does_not_fall_has_no_stribeck_velocity() -> None:
    truth = stribeck_axis()
    flat = truth._replace(breakaway=0.105, laws=truth.laws._replace(stribeck_velocity=0.0))
    fit = stribeck_curve([constant_speeds(3, flat)], clutch(), IdentificationSettings())
    assert set(fit.parameters) == {"coulomb", "viscous", "offset"}
    assert fit.parameters["coulomb"].low <= flat.coulomb <= fit.parameters["coulomb"].high


def test_the_model_has_the_curve_and_can_be_simulated() -> None:
    result = identify_records(
        [constant_speeds(4, stribeck_axis())],
        [],
        clutch(),
        "stribeck-curve",
        IdentificationSettings(),
    )
    model = model_of(result, clutch(), Provenance(command="test", frictool="0"))
    assert model.law == "stribeck"
    assert model.parameters.breakaway.source == "identified"
    assert axis_of(model).laws.stribeck_velocity == pytest.approx(STRIBECK_VELOCITY, rel=0.1)
    assert "breakaway" not in result.refused


@pytest.mark.parametrize("exponent", [2.0, 1.0, 0.5])
def test_the_exponent_is_found(exponent: float) -> None:
    generator = np.random.default_rng(5)
    speed = np.tile(np.geomspace(0.5, 200.0, 30), 2)
    still, samples = np.zeros(60), np.full(60, 300.0)
    runs = ConstantSpeedRuns(speed, np.repeat([1.0, -1.0], 30), still, samples, still)
    exact = runs.design(10.0, exponent) @ np.array([0.1, 0.03, 1e-4, 0.004])
    runs = replace(runs, effort=exact + 1e-4 * generator.standard_normal(60))
    from frictool.identify.estimators.stribeck_curve import _choice

    velocity, found = _choice(runs)
    assert found == exponent
    assert velocity == pytest.approx(10.0, rel=0.1)


def test_sines_are_no_runs() -> None:
    with pytest.raises(UnusableLogs, match="runs at a constant speed forward"):
        stribeck_curve([record(sines(1))], clutch(), IdentificationSettings())


INERTIA, VISCOUS, COULOMB = (1.3e-5, 3e-4, 0.05)


def triangles(settling: float, samples: int, count: float, fall: float = 0.0) -> MotionRecord:
    """Return strokes at four speeds, each of `samples` samples, from an encoder with this count.

    A servo reaches each speed with the time constant `settling` [s]. Coulomb friction falls by
    `fall` with the speed of 15 rad/s.
    """
    period = 1e-3
    time = np.arange(samples) * period
    velocity = np.concatenate(
        [
            sign * speed * (1.0 - 2.0 * np.exp(-time / settling))
            for speed in np.tile([20.0, 60.0, 120.0, 200.0], 4)
            for sign in (1.0, -1.0)
        ]
    )
    acceleration = np.gradient(velocity, period)
    friction = COULOMB + fall * np.exp(-((velocity / 15.0) ** 2))
    effort = INERTIA * acceleration + VISCOUS * velocity + friction * np.sign(velocity)
    effort += np.random.default_rng(6).normal(0.0, 1e-3, effort.size)
    position = scipy.integrate.cumulative_simpson(velocity, dx=period, initial=0.0)
    counts = np.round(position / count) * count
    clock = np.arange(velocity.size) * period
    return make_record("triangles", clock, counts, effort, resolution=count, lag=1.0)


def test_the_curve_holds_while_the_speed_still_settles() -> None:
    """The inertia's mean effort in a run would change viscous friction by several per cent."""
    fit = stribeck_curve([triangles(0.06, 400, 0.11)], clutch(), IdentificationSettings())
    for name, truth in (("viscous", VISCOUS), ("coulomb", COULOMB)):
        assert fit.parameters[name].low <= truth <= fit.parameters[name].high


@pytest.mark.parametrize(("fall", "curve"), [(0.0, False), (0.03, True)])
def test_the_reversals_between_runs_show_the_inertia(fall: float, curve: bool) -> None:
    fit = auto([triangles(0.04, 700, 0.05, fall)], clutch(), IdentificationSettings())
    assert (fit.method == "stribeck-curve") is curve
    assert fit.parameters["inertia"].value == pytest.approx(INERTIA, rel=0.03)
    assert "inertia" not in fit.refused
    for name, truth in (("viscous", VISCOUS), ("coulomb", COULOMB)):
        assert fit.parameters[name].value == pytest.approx(truth, rel=0.01)


def staircase(runs: int, seconds: float) -> MotionRecord:
    """Return one stroke in each direction with `runs` speeds, each lasting `seconds`.

    A servo reaches each speed with a time constant of 0.04 s.
    """
    period = 1e-3
    time = np.arange(round(seconds / period)) * period
    speeds = np.linspace(20.0, 200.0, runs)
    levels = np.concatenate([speeds, -speeds])
    velocity = np.concatenate(
        [
            after + (before - after) * np.exp(-time / 0.04)
            for before, after in zip(np.append(0.0, levels), levels, strict=False)
        ]
    )
    acceleration = np.gradient(velocity, period)
    effort = INERTIA * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity)
    effort += np.random.default_rng(7).normal(0.0, 1e-3, effort.size)
    position = scipy.integrate.cumulative_simpson(velocity, dx=period, initial=0.0)
    counts = np.round(position / 0.02) * 0.02
    clock = np.arange(velocity.size) * period
    return make_record("staircase", clock, counts, effort, resolution=0.02, lag=1.0)


def placeholders() -> Bench:
    """Return a bench with a Coulomb friction that is four times too large, in a wide range."""
    wrong = Quantity(4.0 * COULOMB, 0.0, 10.0 * COULOMB, "N m")
    bench = clutch()
    return structs.replace(bench, mechanics=structs.replace(bench.mechanics, coulomb=wrong))


def test_a_staircase_of_speeds_determines_friction_with_one_stroke_in_each_direction() -> None:
    """The runs are less than 70 % of the motion, and strokes alone do not show their scatter."""
    log = staircase(8, 0.4)
    result = identify_records([log], [], placeholders(), "auto", IdentificationSettings())
    assert result.method == "stribeck-curve"
    for name, truth in (("inertia", INERTIA), ("viscous", VISCOUS), ("coulomb", COULOMB)):
        assert result.identified[name].low <= truth <= result.identified[name].high
        assert result.identified[name].value == pytest.approx(truth, rel=0.05)


def test_a_wrong_value_of_the_bench_does_not_refuse_what_a_log_determines() -> None:
    """With three speeds, Coulomb friction is refused; some value in its range fits the effort."""
    log = staircase(3, 0.4)
    result = identify_records([log], [], placeholders(), "auto", IdentificationSettings())
    assert result.identified["viscous"].value == pytest.approx(VISCOUS, rel=0.05)
    assert "coulomb" in result.refused
    kept = result.narrowed["coulomb"]
    assert kept.value == pytest.approx(COULOMB, rel=0.05)
    assert kept.low == 0.0
    assert kept.high >= 10.0 * COULOMB
    assert result.fit is not None
    assert result.fit.force_error is not None
    assert result.fit.force_error < 0.1
