"""Slow strokes of one speed with rests at the reversals, where the effort is below friction."""

from __future__ import annotations

import functools

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.identification import Identification, identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.typing import Vector
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB, OFFSET = (2e-3, 0.05, 0.3, 0.02)
NOISE = 6e-3  # N m, standard deviation of the effort's noise
RISE, DECAY = (0.02, 0.6)  # s, time constants of the speed after a rest: start, and overshoot
REST = 0.35  # s
SETTINGS = IdentificationSettings()


def bench() -> Bench:
    """Return a bench with a range of a factor 9 of the inertia."""
    known = rotary_bench(None)
    mechanics = msgspec.structs.replace(
        known.mechanics,
        inertia=Quantity(1.3 * INERTIA, INERTIA / 3.0, 3.0 * INERTIA, "kg m^2"),
        viscous=Quantity(1.4 * VISCOUS, 0.0, 5.0 * VISCOUS, "N m s/rad"),
        coulomb=Quantity(0.7 * COULOMB, 0.25 * COULOMB, 3.0 * COULOMB, "N m"),
    )
    return msgspec.structs.replace(known, mechanics=mechanics)


def triangles(seed: int, speed: float, counts: int, period: float) -> MotionRecord:
    """Return a record of 12 strokes of 5 s.

    The speed rises after each rest, exceeds `speed` [rad/s] by half, and decays to it. The effort
    rises linearly during the rest. counts: encoder counts per turn.
    """
    draw = np.random.default_rng(seed)
    moves = np.arange(round(5.0 / period)) * period - REST
    rest = moves < 0.0
    since = np.maximum(moves, 0.0)
    profile = speed * (1.0 - np.exp(-since / RISE)) * (1.0 + 0.5 * np.exp(-since / DECAY))
    ramp = 2.0 * np.clip(moves / REST + 1.0, 0.0, 1.0) - 1.0
    signs = np.tile([1.0, -1.0], 6)
    velocity: Vector = np.concatenate([sign * profile for sign in signs])
    holding: Vector = np.concatenate([sign * np.where(rest, ramp, 1.0) for sign in signs])
    position = np.cumsum(velocity) * period
    effort = INERTIA * np.gradient(velocity, period) + VISCOUS * velocity
    effort[np.tile(rest, 12)] = 0.0
    effort += COULOMB * holding + OFFSET + NOISE * draw.standard_normal(velocity.size)
    step = 2.0 * np.pi / counts
    measured = np.floor(position / step + draw.random()) * step
    return make_record("log", np.arange(velocity.size) * period, measured, effort, step, 1.0)


@functools.cache
def identified(seed: int, speed: float, counts: int, period: float) -> Identification:
    return identify_records([triangles(seed, speed, counts, period)], [], bench(), "auto", SETTINGS)


@pytest.mark.parametrize(
    ("speed", "counts", "period", "seeds", "least"),
    [
        (0.2, 4096, 2e-3, 2, 1),
        pytest.param(0.2, 4096, 2e-3, 12, 10, marks=pytest.mark.accept),
        pytest.param(0.1, 16384, 2e-3, 12, 10, marks=pytest.mark.accept),
        pytest.param(1.0, 1000, 4e-3, 12, 10, marks=pytest.mark.accept),
    ],
)
def test_friction_of_slow_triangles(
    speed: float, counts: int, period: float, seeds: int, least: int
) -> None:
    """The intervals hold, and the rests do not shift the values."""
    truth = {"viscous": VISCOUS, "coulomb": COULOMB, "offset": OFFSET}
    held = dict.fromkeys(truth, 0)
    errors: dict[str, list[float]] = {name: [] for name in truth}
    halves: dict[str, list[float]] = {name: [] for name in truth}
    for seed in range(seeds):
        result = identified(seed, speed, counts, period)
        for name, value in truth.items():
            one = result.identified[name]
            held[name] += one.low <= value <= one.high
            errors[name].append(one.value - value)
            halves[name].append(one.half_width)
    for name in truth:
        assert held[name] >= least
        assert abs(np.mean(errors[name])) < 0.5 * np.median(halves[name])


@pytest.mark.parametrize("seeds", [2, pytest.param(12, marks=pytest.mark.accept)])
def test_an_inertia_that_the_encoder_hides_is_refused(seeds: int) -> None:
    """Noise of the encoder exceeds the acceleration that friction does not explain."""
    for seed in range(seeds):
        result = identified(seed, 0.2, 4096, 2e-3)
        assert "inertia" in result.refused
        narrowed = result.narrowed.get("inertia")
        assert narrowed is None or narrowed.low <= INERTIA <= narrowed.high
