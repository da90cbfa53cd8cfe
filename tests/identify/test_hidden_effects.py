"""A spring and viscous friction by direction resemble parameters, and the residual hides them."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.load_terms import LoadTerms
from frictool.identify.effect_regression import EffectRegression, effect_regression
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.fit_result import Interval
from frictool.identify.hidden_effects import hidden_effects, lasting_rms
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.unmodelled_effects import widened
from frictool.typing import Vector
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB, OFFSET = (1e-3, 0.01, 0.1, 0.02)
AMPLITUDE, RATE = 4.0, 6.0  # rad, rad/s
SIZE = 0.02  # N m, rms effort of each effect
LAG = 16  # rows


def record(seed: int, ripple: float, asymmetry: float, spring: float) -> MotionRecord:
    """Return a record with effects of the rms efforts `ripple`, `asymmetry` and `spring` [N m]."""
    draw = np.random.default_rng(seed)
    time: Vector = np.arange(12_000, dtype=np.float64) * 1e-3
    slow = 0.9 * RATE
    position = 0.7 * AMPLITUDE * np.sin(RATE * time) + 0.3 * AMPLITUDE * np.sin(slow * time)
    velocity = np.gradient(position, time)
    acceleration = np.gradient(velocity, time)
    effort = INERTIA * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity) + OFFSET
    effort += ripple * np.sqrt(2.0) * np.sin(3.0 * position + draw.uniform(0.0, 2.0 * np.pi))
    effort += asymmetry * np.abs(velocity) / np.sqrt(np.mean(velocity**2))
    effort += spring * position / np.std(position)
    effort += 2e-3 * draw.standard_normal(time.size)
    return make_record("log", time, position, effort, resolution=1e-5, lag=1.0)


def intervals(log: MotionRecord, name: str) -> tuple[Interval, Interval]:
    """Return the interval of a parameter by least squares, and the widened interval."""
    bench = rotary_bench(None)
    settings = IdentificationSettings()
    fit = least_squares([log], bench, settings)
    wide = widened(fit, [log], bench, settings.confidence).fit
    return fit.parameters[name], wide.parameters[name]


def regression_of(log: MotionRecord, terms: tuple[str, ...] = ("offset",)) -> EffectRegression:
    bench = msgspec.structs.replace(rotary_bench(None), load=LoadTerms(terms))
    fit = least_squares([log], bench, IdentificationSettings())
    regression = effect_regression(fit, [log], bench, 0.95)
    assert regression is not None
    return regression


@pytest.mark.parametrize(
    ("name", "truth", "logs", "most", "least"),
    [
        ("offset", OFFSET, 8, 4, 7),
        pytest.param("offset", OFFSET, 20, 10, 18, marks=pytest.mark.accept),
        pytest.param("inertia", INERTIA, 20, 10, 18, marks=pytest.mark.accept),
    ],
)
def test_the_intervals_hold_over_random_hidden_effects(
    name: str, truth: float, logs: int, most: int, least: int
) -> None:
    plain, wide = 0, 0
    halves, errors = [], []
    for seed in range(logs):
        draw = np.random.default_rng((seed, 1))
        asymmetry, spring = SIZE * draw.standard_normal(2)
        log = record(seed, SIZE, asymmetry, spring)
        one, other = intervals(log, name)
        plain += one.low <= truth <= one.high
        wide += other.low <= truth <= other.high
        halves.append(other.half_width)
        errors.append(other.value - truth)
    assert plain <= most
    assert wide >= least
    assert np.median(halves) < 3.0 * np.sqrt(np.mean(np.square(errors)))


def test_a_true_model_has_no_hidden_effects() -> None:
    bench = rotary_bench(None)
    regressions = [regression_of(record(seed, 0.0, 0.0, 0.0)) for seed in range(20)]
    found = [hidden_effects(one, bench) for one in regressions]
    assert sum(map(bool, found)) <= 3


def test_an_effect_of_the_model_is_not_hidden() -> None:
    log, bench = record(1, SIZE, 0.0, 0.0), rotary_bench(None)
    both = {one.what for one in hidden_effects(regression_of(log), bench)}
    rest = {one.what for one in hidden_effects(regression_of(log, ("offset", "spring")), bench)}
    assert both == {("viscous friction by direction",), ("a spring",)}
    assert rest == {("viscous friction by direction",)}


def test_declared_loads_exclude_a_hidden_spring() -> None:
    log, bench = record(2, SIZE, 0.0, 0.0), rotary_bench(None)
    declared = msgspec.structs.replace(bench, load=LoadTerms(("offset",)))
    settings = IdentificationSettings()
    fit = least_squares([log], bench, settings)
    free, known = (widened(fit, [log], one, settings.confidence) for one in (bench, declared))
    halves = [one.fit.parameters["inertia"].half_width for one in (known, free)]
    assert halves[1] > 1.5 * halves[0]
    (note,) = free.notes(free.fit.parameters)
    assert "declare load.terms: [offset]" in note
    assert not known.notes(known.fit.parameters)


def test_only_residuals_that_last_longer_than_the_lag_count() -> None:
    stroke = np.repeat(np.arange(30), 100)
    draw = np.random.default_rng(3)
    lasting = []
    for _ in range(100):
        noise = draw.standard_normal(stroke.size + LAG - 1)
        smooth = np.convolve(noise, np.full(LAG, 1.0 / LAG), mode="valid")
        lasting.append(lasting_rms(smooth, stroke, LAG, 0.95))
    assert np.count_nonzero(lasting) <= 10
    levels = 0.3 * draw.standard_normal(30)[stroke]
    noise = draw.standard_normal(stroke.size)
    size = float(np.sqrt(np.mean(levels**2)))
    assert lasting_rms(levels + noise, stroke, LAG, 0.95) == pytest.approx(size, rel=0.2)


def test_strokes_shorter_than_the_lag_show_nothing() -> None:
    stroke = np.repeat(np.arange(30), LAG)
    assert lasting_rms(np.ones(stroke.size), stroke, LAG, 0.95) == 0.0
