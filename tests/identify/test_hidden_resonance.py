"""A load behind a spring increases the reflected inertia below the resonance."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.identify.effect_regression import effect_regression
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.fit_result import Interval
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.unmodelled_effects import SMOOTHER, widened
from frictool.typing import Vector
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB = (1e-3, 0.004, 0.1)
SHARE = 0.6  # of the inertia behind the spring
SETTINGS = IdentificationSettings()
STEP = 2.0 * np.pi / 100_000


def record(seed: int, frequency: float) -> MotionRecord:
    """Return a record whose load has an antiresonance at `frequency` [Hz]; inf for a rigid axis.

    The motion x of the load determines the motor's position x + x''/w^2 and the effort.
    """
    draw = np.random.default_rng(seed)
    time: Vector = np.arange(12_000, dtype=np.float64) * 1e-3
    motion = np.zeros((5, time.size))  # x and its derivatives
    for hertz, size in ((0.6, 4.0), (1.3, 1.5), (3.1, 0.5)):
        rate, phase = 2.0 * np.pi * hertz * draw.uniform(0.9, 1.1), draw.uniform(0.0, 2.0 * np.pi)
        for order in range(5):
            motion[order] += size * rate**order * np.sin(rate * time + phase + order * np.pi / 2.0)
    position, velocity, acceleration = motion[:3] + motion[2:] / (2.0 * np.pi * frequency) ** 2
    effort = INERTIA * ((1.0 - SHARE) * acceleration + SHARE * motion[2])
    effort += VISCOUS * velocity + COULOMB * np.sign(velocity)
    effort += 3e-3 * draw.standard_normal(time.size)
    counts = np.floor(position / STEP + draw.random())
    return make_record("log", time, counts * STEP, effort, resolution=STEP, lag=1.0)


def inertias(log: MotionRecord) -> tuple[Interval, Interval]:
    """Return the interval of the inertia by least squares, and the widened interval."""
    bench = rotary_bench(None)
    fit = least_squares([log], bench, SETTINGS)
    wide = widened(fit, [log], bench, SETTINGS.confidence).fit
    return fit.parameters["inertia"], wide.parameters["inertia"]


@pytest.mark.parametrize(
    ("logs", "most", "least"), [(6, 1, 5), pytest.param(20, 2, 18, marks=pytest.mark.accept)]
)
def test_the_inertia_holds_below_a_resonance(logs: int, most: int, least: int) -> None:
    plain, held = 0, 0
    for seed in range(logs):
        one, wide = inertias(record(seed, 25.0))
        plain += one.low <= INERTIA <= one.high
        held += wide.low <= INERTIA <= wide.high
    assert plain <= most
    assert held >= least


def test_a_rigid_axis_shows_no_resonance() -> None:
    bench = rotary_bench(None)
    found = 0
    for seed in range(20):
        log = record(seed, np.inf)
        fit = least_squares([log], bench, SETTINGS)
        regression = effect_regression(fit, [log], bench, SETTINGS.confidence, SMOOTHER)
        assert regression is not None
        found += regression.resonant_inertia() is not None
    assert found <= 2


def test_the_coefficient_of_the_resonance_agrees_with_the_spring() -> None:
    """The regression finds the true inertia, and -J share/w^2 for the antiresonance w.

    Noise of the encoder makes the coefficient smaller.
    """
    bench = rotary_bench(None)
    log = record(3, 25.0)
    fit = least_squares([log], bench, SETTINGS)
    regression = effect_regression(fit, [log], bench, SETTINGS.confidence, SMOOTHER)
    assert regression is not None
    seen = regression.resonant_inertia()
    assert seen is not None
    assert abs(seen.value / INERTIA - 1.0) < 0.01
    (resonance,) = [one for one in regression.free if one.term == "resonance"]
    coefficient = regression.intervals([resonance])["resonance"].value
    expected = -INERTIA * SHARE / (2.0 * np.pi * 25.0) ** 2
    assert 0.5 < coefficient / expected < 1.1
