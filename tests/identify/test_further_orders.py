"""Friction over position has further orders than the columns of the fit."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from numpy.polynomial import legendre

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.identify.effect_regression import effect_regression
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.further_orders import further_orders
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.unmodelled_effects import widened
from frictool.typing import Vector
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB, OFFSET = (1e-3, 0.01, 0.1, 0.02)
AMPLITUDE, RATE = 4.0, 6.0  # rad, rad/s
SIZE = 0.02  # N m, deviation of the first coefficient of the friction over position
ORDERS = np.arange(1, 9)


@pytest.fixture
def bench() -> Bench:
    terms = LoadTerms(("offset", "friction_over_position"))
    return msgspec.structs.replace(rotary_bench(None), load=terms)


def record(seed: int, noise: float = 2e-3) -> MotionRecord:
    """Return a record of equal strokes with a random friction over position.

    `noise` is the standard deviation of the effort's noise [N m].
    """
    draw = np.random.default_rng(seed)
    time: Vector = np.arange(12_000, dtype=np.float64) * 1e-3
    position = AMPLITUDE * np.sin(RATE * time)
    velocity = AMPLITUDE * RATE * np.cos(RATE * time)
    coefficients = np.append(0.0, SIZE / ORDERS**2 * draw.standard_normal(ORDERS.size))
    level = COULOMB + legendre.legval(position / AMPLITUDE, coefficients)
    effort = OFFSET - INERTIA * RATE**2 * position + VISCOUS * velocity
    effort += level * np.sign(velocity) + noise * draw.standard_normal(time.size)
    return make_record("log", time, position, effort, resolution=1e-5, lag=1.0)


@pytest.mark.parametrize(
    ("logs", "most", "least"), [(8, 5, 7), pytest.param(20, 12, 18, marks=pytest.mark.accept)]
)
def test_the_intervals_hold_over_random_friction_of_further_orders(
    bench: Bench, logs: int, most: int, least: int
) -> None:
    settings = IdentificationSettings()
    plain, wide = 0, 0
    for seed in range(logs):
        log = record(seed)
        fit = least_squares([log], bench, settings)
        result = widened(fit, [log], bench, settings.confidence).fit
        one, other = fit.parameters["viscous"], result.parameters["viscous"]
        plain += one.low <= VISCOUS <= one.high
        wide += other.low <= VISCOUS <= other.high
        assert other.half_width < VISCOUS
    assert plain <= most
    assert wide >= least


@pytest.mark.parametrize(
    ("logs", "dropped", "least"), [(8, 4, 7), pytest.param(20, 10, 18, marks=pytest.mark.accept)]
)
def test_an_order_that_the_log_does_not_determine_is_left_out(
    bench: Bench, logs: int, dropped: int, least: int
) -> None:
    """Over equal strokes, s P_2 resembles viscous friction, so that noise hides s P_2."""
    settings = IdentificationSettings()
    left_out, held = 0, 0
    for seed in range(logs):
        log = record(seed, noise=0.3)
        fit = least_squares([log], bench, settings)
        result = widened(fit, [log], bench, settings.confidence).fit
        left_out += "friction_over_position_2" in fit.dropped
        held += result.parameters["viscous"].low <= VISCOUS <= result.parameters["viscous"].high
    assert left_out >= dropped
    assert held >= least


def test_a_fit_without_friction_over_position_has_no_further_orders() -> None:
    bench = rotary_bench(None)
    log = record(1)
    fit = least_squares([log], bench, IdentificationSettings())
    regression = effect_regression(fit, [log], bench, 0.95)
    assert regression is not None
    assert further_orders(regression) is None
