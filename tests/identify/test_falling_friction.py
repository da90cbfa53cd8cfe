"""Friction that falls with speed widens intervals, although logs have few speeds and a load."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.load_terms import LoadTerms
from frictool.identify.effect_regression import effect_regression
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.falling_friction import falling_friction
from frictool.identify.fit_result import Explanation, SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.effects import WHAT
from frictool.identify.unmodelled_effects import widened
from tests.support.loaded_axis import rotary_bench

INERTIA, VISCOUS, COULOMB = (0.02, 3.0, 0.4)
PERIOD = 0.01  # s
TOP = 0.25  # rad/s
SETTINGS = IdentificationSettings()


def strokes(fall: float, speed: float, seed: int) -> list[MotionRecord]:
    """Return two logs of strokes; `fall` [N m] decreases exponentially with (v/speed)^2.

    A load over the position resembles gravity, but is not the same.
    """
    draw = np.random.default_rng(seed)
    out = []
    for shares in ((0.12, 0.25, 0.4), (0.3, 0.6, 1.0)):
        parts = []
        for share in shares:
            size = round(1.2 / (share * TOP * PERIOD))
            ramp = np.minimum(1.0, np.minimum(np.arange(size), np.arange(size)[::-1]) / 15.0)
            parts += [share * TOP * ramp, -share * TOP * ramp]
        velocity = np.concatenate(parts)
        time = np.arange(velocity.size) * PERIOD
        position = np.cumsum(velocity) * PERIOD
        effort = INERTIA * np.gradient(velocity, PERIOD) + VISCOUS * velocity
        effort += np.sign(velocity) * (COULOMB + fall * np.exp(-((velocity / speed) ** 2)))
        effort += 0.3 * position**2 * (1.3 - position) + draw.normal(0.0, 0.01, time.size)
        noisy = position + draw.normal(0.0, 1e-5, time.size)
        out.append(make_record("log", time, noisy, effort, resolution=1e-5, lag=1.0))
    return out


def fit_with(records: list[MotionRecord], *terms: str) -> SlidingFit:
    """Return the fit of least squares with the load `terms`, as if `auto` had selected them."""
    load = LoadTerms(("offset", *terms))
    bench = msgspec.structs.replace(rotary_bench(None), load=load)
    return replace(least_squares(records, bench, SETTINGS), load=load, method="least-squares")


@pytest.mark.parametrize("seed", [1, 2])
def test_the_intervals_include_a_fall_in_addition_to_a_load(seed: int) -> None:
    records = strokes(0.2, 0.08, seed)
    fit = fit_with(records, "gravity")
    wide = widened(fit, records, rotary_bench(None), 0.95).fit.parameters
    for name, truth in (("viscous", VISCOUS), ("coulomb", COULOMB)):
        plain = fit.parameters[name]
        assert not plain.low <= truth <= plain.high
        assert wide[name].low <= truth <= wide[name].high


def test_no_fall_is_found_where_none_acts() -> None:
    found = 0
    for seed in range(10):
        records = strokes(0.0, 1.0, seed)
        fit = fit_with(records, "gravity", "load_over_position")
        regression = effect_regression(fit, records, rotary_bench(None), 0.95)
        assert regression is not None
        found += bool(falling_friction(regression))
    assert found <= 2


def test_the_interval_includes_the_fit_with_a_rival() -> None:
    """A lag of the position sensor adds lag times viscous friction to the inertia."""
    time = np.arange(1500) * PERIOD
    lag = 0.05  # s
    terms = [(0.3, 2.0, 0.0), (0.1, 5.3, 0.4), (0.02, 11.0, 1.0)]
    seen = [
        sum(
            size * rate**k * np.sin(rate * time + phase + 0.5 * k * np.pi)
            for size, rate, phase in terms
        )
        for k in range(4)
    ]
    velocity, acceleration = (seen[k] + lag * seen[k + 1] for k in (1, 2))
    effort = 0.2 * acceleration + VISCOUS * velocity + COULOMB * np.sign(velocity)
    effort += np.random.default_rng(1).normal(0.0, 0.02, time.size)
    record = make_record("log", time, np.asarray(seen[0]), effort, resolution=1e-6, lag=1.0)
    fit = fit_with([record], "resonance")
    rival = Explanation("resonance", "", "used", 0.0, 0.0, 1.0, "", (WHAT["delay"],))
    alone, both = (
        widened(one, [record], rotary_bench(None), 0.95).fit.parameters["inertia"]
        for one in (fit, replace(fit, explanations=(rival,)))
    )
    late = fit_with([record], "delay").parameters["inertia"]
    assert both.low <= late.low
    assert both.low <= 0.2 <= both.high
    assert alone.low > 0.2
