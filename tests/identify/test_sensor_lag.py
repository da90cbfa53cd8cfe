"""Lag of the position sensor: stated in the bench, fitted to the log, or in doubt."""

from __future__ import annotations

import functools
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from scipy.signal import lfilter

from frictool.documents.bench import Bench, Encoder
from frictool.documents.missing_effects import missing_sensor_lag
from frictool.errors import NoSolutionError
from frictool.identify import fitted_lag
from frictool.identify.fit_result import Interval
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.identify.motion_record import make_record, sensed
from frictool.logs import log_of
from frictool.simulate.rig import rig_of
from frictool.typing import Vector
from tests.support.linear_axis import linear_bench

PERIOD, FINE = (2e-3, 20)  # s; steps per sample
LAG = 0.05  # s
RATE = 5.0  # rad/s
INERTIA, VISCOUS, COULOMB = (5.0, 20.0, 8.0)  # kg, N s/m, N


def lag_filter(lag: float, period: float, values: Vector) -> Vector:
    """Return the values (n,) after a first-order lag [s], in steps of `period` [s]."""
    pole = np.exp(-period / lag)
    return np.asarray(lfilter([1.0 - pole], [1.0, -pole], values, zi=[pole * values[0]])[0])


@functools.cache
def identified(rate: float, lag: float, stated: float | None) -> IdentifiedModel:
    """Return the model of strokes at about `rate` [rad/s], with the effort of the motion."""
    draw = np.random.default_rng(int(100.0 * rate))
    time = np.arange(10_000 * FINE) * PERIOD / FINE
    x = np.zeros(time.size)
    for size, factor in ((0.3, 0.4), (0.2, 0.9), (0.1, 1.7)):
        x += size * np.sin(factor * rate * time + draw.uniform(0.0, 6.0))
    v: Vector = np.gradient(x, time)
    effort: Vector = INERTIA * np.gradient(v, time) + VISCOUS * v + COULOMB * np.sign(v)
    seen = lag_filter(lag, PERIOD / FINE, x) if lag else x
    held = effort.reshape(-1, FINE).mean(axis=1)
    noisy = held + 0.02 * draw.standard_normal(held.size)
    count = 1e-5
    log = log_of(
        time[::FINE],
        {"position": np.floor(seen[::FINE] / count) * count, "effort": noisy},
        axis="linear",
    )
    return identify([log], bench(stated))


def bench(stated: float | None) -> Bench:
    """Return the bench of the axis; `stated` is the key encoder.time_constant_s."""
    plain = linear_bench()
    encoder = Encoder(step=plain.encoder.step, time_constant_s=stated)
    return msgspec.structs.replace(plain, sample_period_s=PERIOD, encoder=encoder)


@pytest.mark.parametrize("stated", [None, LAG])
def test_the_inertia_does_not_contain_lag_times_viscous_friction(stated: float | None) -> None:
    """Lag times viscous friction is 20 % of the inertia."""
    model = identified(RATE, LAG, stated)
    found = model.result.identified
    for name, true in (("inertia", INERTIA), ("viscous", VISCOUS), ("coulomb", COULOMB)):
        assert found[name].value == pytest.approx(true, rel=0.01), name
    told = [one for one in model.result.warnings if "follows the effort with a lag" in one]
    assert bool(told) == (stated is None)
    if stated is None:
        assert -model.result.fit.effects["delay"].value == pytest.approx(LAG, rel=0.1)
        assert len(told[0]) <= 190


@pytest.mark.parametrize(("inertia", "lag"), [(-0.012, None), (VISCOUS * LAG, LAG)])
def test_a_lag_exchanged_with_the_inertia_exceeds_the_rounding_of_a_row(
    monkeypatch: pytest.MonkeyPatch, inertia: float, lag: float | None
) -> None:
    """The fitted lag of 0.25 s is the axis's own; the inertia left is the sensor's lag, or noise.
    A filter with a negative lag is unstable."""
    around = Interval.around
    left = {"inertia": around(inertia, 0.015), "viscous": around(VISCOUS, 0.1)}
    regression = SimpleNamespace(intervals=lambda: left)
    own = fitted_lag.LateFit(regression, INERTIA / VISCOUS, around(0.0, 1e-3), 1.0)
    monkeypatch.setattr(fitted_lag, "effect_regression", lambda *_: regression)
    monkeypatch.setattr(fitted_lag, "late_fit", lambda *args: own if args[-1] is sensed else None)
    record = make_record("log", np.arange(9) * PERIOD, np.zeros(9), np.zeros(9), 1e-6, 0.0)
    fit = SimpleNamespace(effects={"delay": around(-INERTIA / VISCOUS, 1e-3)})
    found = fitted_lag.fitted_lag(fit, [record], bench(None), 0.95)
    assert (None if found is None else found.value) == lag


def test_no_lag_is_claimed_without_a_lag() -> None:
    found = identified(RATE, 0.0, None).result
    assert "delay" not in found.fit.effects
    assert not [one for one in found.warnings if "lag" in one]


@pytest.mark.parametrize("drive_lag", [0.0, 4e-3])
def test_the_filter_of_a_sampled_effort_is_exact(drive_lag: float) -> None:
    """The effort is held between samples, or moves exponentially to the next command."""
    draw = np.random.default_rng(3)
    command = np.repeat(draw.standard_normal(200), 4_000)
    step = PERIOD / 4_000
    acting = lag_filter(drive_lag, step, command) if drive_lag else command
    clock = np.arange(200) * PERIOD
    logged = acting[::4_000]
    record = make_record("log", clock, np.cumsum(logged), logged, 1e-6, drive_lag)
    exact = lag_filter(LAG, step, acting)[::4_000]
    assert np.allclose(sensed(record, LAG).effort[1:], exact[1:], atol=2e-4)


def test_other_stages_refuse_a_sensor_with_a_lag() -> None:
    with pytest.raises(NoSolutionError, match=r"encoder\.time_constant_s: found 0\.05 s"):
        rig_of(bench(LAG))
    rig_of(bench(0.0))
    text = missing_sensor_lag(identified(RATE, LAG, LAG).model)
    assert text is not None
    assert "encoder.time_constant_s" in text
    assert len(text) <= 190
