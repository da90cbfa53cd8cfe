"""Strokes of one speed separate viscous from Coulomb friction at their reversals only."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.effect_regression import effect_regression
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.regression_samples import RegressionSamples, fit
from frictool.identify.unmodelled_effects import widened
from frictool.typing import Vector
from tests.support.loaded_axis import rotary_bench

PERIOD, INERTIA = 1e-3, 1.0
TIME = np.arange(9_000) * PERIOD
SETTINGS = IdentificationSettings()


@dataclass(frozen=True)
class Strokes:
    """Strokes of one speed: position and effort without noise (n,), and the encoder's step in rad.

    viscous and coulomb are the truth; the inertia is INERTIA.
    """

    position: Vector
    effort: Vector
    step: float
    viscous: float
    coulomb: float

    @property
    def bench(self) -> Bench:
        """Return a bench with wide ranges."""
        bench = rotary_bench(None)
        mechanics = msgspec.structs.replace(
            bench.mechanics,
            inertia=Quantity(INERTIA, 0.6 * INERTIA, 1.6 * INERTIA, "kg m^2"),
            viscous=Quantity(self.viscous, 0.0, 50.0 * self.viscous, "N m s/rad"),
            coulomb=Quantity(self.coulomb, 0.0, 20.0 * self.coulomb, "N m"),
        )
        return msgspec.structs.replace(bench, mechanics=mechanics)

    def record(self, phase: float, noise: Vector | float = 0.0) -> MotionRecord:
        """Return the record by an encoder with its zero at `phase` counts."""
        position = np.floor(self.position / self.step + phase) * self.step
        return make_record("log", TIME, position, self.effort + noise, self.step, 1.0)


def smooth(draw: np.random.Generator) -> Vector:
    """Return the velocity (n,) of equal strokes with smooth reversals of 60 to 160 ms."""
    speed = draw.uniform(0.5, 2.0)
    half = int(draw.uniform(0.3, 0.7) / PERIOD)
    ramp = draw.uniform(0.03, 0.08) / PERIOD
    index = np.arange(TIME.size)
    inside = index % half
    edge = np.clip(np.minimum(inside + 0.5, half - inside - 0.5) / ramp, 0.0, 1.0)
    sign = np.where(index % (2 * half) < half, 1.0, -1.0)
    return np.asarray(sign * speed * edge * edge * (3.0 - 2.0 * edge))


def exponential(draw: np.random.Generator) -> Vector:
    """Return the velocity (n,) of strokes that approach their speed exponentially."""
    speed, half = draw.uniform(0.5, 2.0), draw.uniform(0.3, 0.7)
    time_constant = draw.uniform(0.015, 0.04)
    half += 0.0137 * draw.random()  # no multiple of the sample period
    sign = np.where(np.mod(TIME, 2.0 * half) < half, 1.0, -1.0)
    return np.asarray(sign * speed * (1.0 - 2.0 * np.exp(-np.mod(TIME, half) / time_constant)))


def machine_of(
    draw: np.random.Generator, velocity: Vector, viscous: tuple[float, float], counts: float
) -> Strokes:
    """Return the strokes of a random machine.

    viscous: range of viscous friction relative to Coulomb friction. counts: counts of a turn.
    """
    speed = float(np.max(np.abs(velocity)))
    acceleration = np.gradient(velocity, PERIOD)
    position = np.append(0.0, np.cumsum(0.5 * (velocity[1:] + velocity[:-1])) * PERIOD)
    coulomb = 0.1 * draw.uniform(0.5, 3.0) * INERTIA * float(np.max(np.abs(acceleration)))
    damping = draw.uniform(*viscous) * coulomb / speed
    effort = INERTIA * acceleration + damping * velocity + coulomb * np.sign(velocity)
    return Strokes(position, effort, 2.0 * np.pi / int(counts), damping, coulomb)


def test_noise_that_attenuates_the_inertia_widens_the_intervals() -> None:
    """A smaller inertia looks in the reversals like another viscous and Coulomb friction."""
    attenuated, missed = 0, 0
    for seed in range(10):
        draw = np.random.default_rng([seed, 51])
        velocity = exponential(draw)
        machine = machine_of(draw, velocity, (0.2, 1.0), 10.0 ** draw.uniform(3.0, 3.9))
        noise = 0.01 * np.max(np.abs(machine.effort)) * draw.standard_normal(TIME.size)
        result = least_squares([machine.record(draw.random(), noise)], machine.bench, SETTINGS)
        interval = result.parameters["viscous"]
        missed += not interval.low <= machine.viscous <= interval.high
        if result.attenuation > 0.0:
            inertia = result.parameters["inertia"]
            attenuated += 1
            missed += not inertia.low <= INERTIA <= inertia.high / (1.0 - 2.0 * result.attenuation)
    assert attenuated > 5
    assert missed <= 2  # of intervals at 95 %


def test_noise_that_repeats_in_every_stroke_is_in_the_interval() -> None:
    """Equal strokes pass the same counts: no stroke shows the error of the others."""
    draw = np.random.default_rng([5, 52])
    machine = machine_of(draw, smooth(draw), (0.05, 0.4), 2e4)
    noise = 1e-3 * np.max(np.abs(machine.effort)) * draw.standard_normal(TIME.size)
    fits = [
        least_squares([machine.record(phase, noise)], machine.bench, SETTINGS)
        for phase in np.arange(8) / 8.0
    ]
    errors = np.array([one.parameters["inertia"].value - INERTIA for one in fits])
    wide = widened(fits[0], [machine.record(0.0, noise)], machine.bench, 0.95).fit
    assert wide.parameters["inertia"].half_width > 1.5 * float(np.sqrt(np.mean(errors**2)))


def test_coulomb_friction_includes_the_viscous_friction_that_was_dropped() -> None:
    viscous, coulomb, rows, length = 0.2, 1.0, 4_000, 100
    dropped = 0
    for seed in range(12):
        draw = np.random.default_rng([seed, 53])
        stroke = np.arange(rows) // length
        sign = np.where(stroke % 2 == 0, 1.0, -1.0)
        velocity = sign * (1.0 + 0.02 * draw.standard_normal(rows))
        acceleration = draw.standard_normal(rows)
        effort = INERTIA * acceleration + viscous * velocity + coulomb * sign
        effort += 0.3 * draw.standard_normal(rows)
        samples = RegressionSamples(
            acceleration, velocity, effort, stroke, sign, np.full(rows, 10.0)
        )
        result = fit(samples, np.ones(rows), 1, 0.95, {}, ("viscous",))
        if result.dropped:
            dropped += 1
            interval = result.parameters["coulomb"]
            assert interval.low <= coulomb <= interval.high
    assert dropped > 3


def test_coulomb_friction_belongs_to_the_viscous_friction_of_the_model() -> None:
    """Friction falls with speed, so that viscous friction is negative, and the bench's is used."""
    velocity = 4.0 * np.cos(4.0 * TIME) + 3.0 * np.cos(9.1 * TIME)
    position = np.sin(4.0 * TIME) + 3.0 / 9.1 * np.sin(9.1 * TIME)
    acceleration = -16.0 * np.sin(4.0 * TIME) - 27.3 * np.sin(9.1 * TIME)
    noise = np.random.default_rng(54).normal(0.0, 0.1, TIME.size)
    friction = 20.0 * np.sign(velocity) - 1.5 * velocity
    machine = Strokes(position, INERTIA * acceleration + friction, 1e-5, 0.1, 20.0)
    record = machine.record(0.0, noise)
    result = identify_records([record], [], machine.bench, "least-squares", SETTINGS)
    assert "negative" in result.refused["viscous"]
    slips = np.abs(velocity) > 0.2
    mean = float(np.mean(20.0 - (1.5 + machine.viscous) * np.abs(velocity[slips])))
    assert result.identified["coulomb"].value == pytest.approx(mean, rel=0.05)


@pytest.mark.parametrize("few", [True, False])
def test_noise_of_the_acceleration_adds_a_variance_if_few_rows_determine_viscous_friction(
    few: bool,
) -> None:
    """The reversals alone determine it in strokes of one speed, half of the rows in sines."""
    draw = np.random.default_rng([5, 52])
    velocity = smooth(draw) if few else 4.0 * np.cos(4.0 * TIME) + 3.0 * np.cos(9.1 * TIME)
    machine = machine_of(draw, velocity, (0.05, 0.4), 2e4)
    record = machine.record(0.0, 1e-3 * float(np.max(np.abs(machine.effort))))
    result = least_squares([record], machine.bench, SETTINGS)
    regression = effect_regression(result, [record], machine.bench, 0.95)
    assert regression is not None
    used = regression.used
    variance = regression._variance_by_noise(regression.rows.table(used), used)
    assert bool(np.all(variance > 0.0)) is few
    assert bool(np.all(variance == 0.0)) is not few
