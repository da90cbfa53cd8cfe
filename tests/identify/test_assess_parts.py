"""The figures that assess decides by: each against a plain computation of the same, or a simulation
of what it predicts."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.identify.assess.assessment import WANTED
from frictool.identify.assess.assessment_inputs import (
    AssessmentInputs,
    AssessmentRequest,
    facts_of,
    known_widths,
)
from frictool.identify.assess.entropy import metric_entropy, sensor_entropy
from frictool.identify.assess.noise_filter import filter_for, noise_ratio
from frictool.identify.assess.quantisation import inertia_error, viscous_error
from frictool.identify.assess.ramp_precision import SPREAD, ramp_precision
from frictool.identify.assess.sines_precision import sines_half_width
from frictool.identify.assess.weak_form_precision import weak_deviation
from frictool.identify.estimators import auto
from frictool.identify.excite.cramer_rao import (
    PlannedStroke,
    PriorAxis,
    SensorPrecision,
    cramer_rao,
    regressors,
)
from frictool.plant.weak_form import sampled_test_function
from studies.rigs.identification_rigs import clutch

AXIS = PriorAxis(inertia=2.0, viscous=3.0, coulomb=1.0)
SENSING = SensorPrecision(period=1e-3, step=1e-4, noise=0.05)
STROKES = [PlannedStroke(1.0, 0.12), PlannedStroke(0.5, 0.12, 2.0)]


def test_a_parameter_without_an_interval_in_the_bench_has_no_known_width() -> None:
    """The clutch's bench states an interval for each of these, and no breakaway."""
    mechanics = clutch().mechanics
    expected = {
        name: 0.5 * (quantity.high - quantity.low) / quantity.value
        for name, quantity in (
            ("inertia", mechanics.inertia),
            ("viscous", mechanics.viscous),
            ("coulomb", mechanics.coulomb),
        )
    }
    assert known_widths(clutch()) == pytest.approx(expected)


def test_bounds_of_the_thesis() -> None:
    assert inertia_error(1.32e-5, 2.0 * math.pi / 56.0, 1e-3, 1.0) == pytest.approx(
        2.96, abs=0.01
    )  # "presque 300 %" (4.4.1)
    assert viscous_error(1e-4, 1e-3, 10.0) == pytest.approx(0.01)  # 4.2.5.4
    assert inertia_error(2.0, 1e-4, 1e-3, 5.0, 0.25) == pytest.approx(
        0.5 * inertia_error(2.0, 1e-4, 1e-3, 5.0)
    )


@given(st.lists(st.floats(-50.0, 50.0), min_size=3, max_size=3), st.floats(1e-3, 1.0))
def test_no_double_difference_of_counts_errs_by_more_than_the_bound(
    place: list[float], step: float
) -> None:
    x = np.array(place)
    error = np.abs((x[2] - 2.0 * x[1] + x[0]) - step * np.diff(np.floor(x / step), 2)[0])
    # (4.3) with inertia, effort and period 1; offsets of half a count cancel in the difference
    assert error <= inertia_error(1.0, step, 1.0, 1.0) * (1.0 + 1e-9) + 1e-12


@given(st.floats(1e-4, 0.95))
def test_filter_for_leaves_the_ratio(ratio: float) -> None:
    assert noise_ratio(filter_for(ratio, 1e-3), 1e-3) == pytest.approx(ratio, rel=1e-9)


def test_noise_ratio_is_the_share_of_the_power_that_the_filter_passes() -> None:
    tau, period = 2.5e-3, 1e-3
    f = np.linspace(0.0, 1.0 / period, 200_001)
    passed = (
        np.trapezoid(1.0 / (1.0 + (2.0 * np.pi * tau * f) ** 2), f) * period
    )  # (4.5) over the white noise's
    assert noise_ratio(tau, period) == pytest.approx(passed, rel=1e-6)
    assert noise_ratio(tau, period) == pytest.approx(0.096, abs=5e-4)  # 4.2.5.4: 90.4 % taken away
    with pytest.raises(ValueError, match="allowed"):
        filter_for(1.0, period)


@given(st.lists(st.floats(0.01, 1.0), min_size=2, max_size=50))
def test_equal_counts_tell_the_most(weights: list[float]) -> None:
    measures = np.array(weights) / sum(weights)
    assert metric_entropy(measures) <= math.log(len(weights)) + 1e-12


def test_doubling_the_resolution_adds_one_bit_and_the_square_doubles_the_information() -> None:
    one, two = sensor_entropy(63.0, 0.1), sensor_entropy(63.0, 0.05)
    assert metric_entropy(np.full(630, 1.0 / 630.0)) == pytest.approx(one.nats)
    assert two.bits - one.bits == pytest.approx(1.0)
    assert one.gain == pytest.approx((two.nats - one.nats) / one.nats)
    assert sensor_entropy(63.0, 63.0 / one.squared).nats == pytest.approx(2.0 * one.nats)


def test_cramer_rao_is_the_inverse_of_the_information_with_a_dense_covariance() -> None:
    taps = {
        -1: AXIS.inertia / SENSING.period**2 - 0.5 * AXIS.viscous / SENSING.period,
        0: -2.0 * AXIS.inertia / SENSING.period**2,
        1: AXIS.inertia / SENSING.period**2 + 0.5 * AXIS.viscous / SENSING.period,
    }
    total = np.zeros((4, 4))
    for stroke in STROKES:
        g = regressors(stroke, AXIS, SENSING)
        n = g.shape[0]
        h = sum(value * np.eye(n, n + 2, 1 + shift) for shift, value in taps.items())
        v = SENSING.noise**2 * np.eye(n) + SENSING.step**2 / 12.0 * (h @ h.T)
        for sign in (1.0, -1.0):
            both = g * np.array([sign, sign, sign, 1.0])
            total += stroke.times * both.T @ np.linalg.solve(v, both)
    assert cramer_rao(STROKES, AXIS, SENSING) == pytest.approx(
        np.sqrt(np.diag(np.linalg.inv(total))), rel=1e-6
    )


def test_strokes_that_tell_nothing_bound_nothing() -> None:
    behind = PriorAxis(2.0, 3.0, 1.0, backlash=1.0)  # wider than the stroke
    assert np.isinf(cramer_rao(STROKES, behind, SENSING)).all()
    assert np.isinf(weak_deviation(STROKES, behind, SENSING)[0]).all()


@given(st.floats(1e-6, 1e-3), st.floats(1e-3, 1.0), st.floats(0.1, 10.0))
def test_no_estimator_beats_the_bound(step: float, noise: float, inertia: float) -> None:
    axis, sensing = PriorAxis(inertia, 3.0, 1.0), SensorPrecision(1e-3, step, noise)
    assert np.all(
        weak_deviation(STROKES, axis, sensing)[0]
        >= cramer_rao(STROKES, axis, sensing) * (1.0 - 1e-9)
    )


def test_the_weak_form_errs_as_predicted() -> None:
    """White noises on a half sine and its mirror, the estimator written out: rms over draws."""
    predicted, window = weak_deviation([STROKES[0]], AXIS, SENSING)
    draw, errors, truth = (
        np.random.default_rng(5),
        [],
        np.array([AXIS.inertia, AXIS.viscous, AXIS.coulomb, 0.4]),
    )
    phi = sampled_test_function(window)
    g = regressors(STROKES[0], AXIS, SENSING)
    n = g.shape[0]
    velocity, acceleration = g[:, 1], g[:, 0]
    position = (
        np.concatenate(([0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1])))) * SENSING.period
    )
    for _ in range(300):
        rows, right = [], []
        for sign in (1.0, -1.0):
            x = sign * position + SENSING.step / math.sqrt(12.0) * draw.standard_normal(n)
            u = sign * (AXIS.inertia * acceleration + AXIS.viscous * velocity + AXIS.coulomb) + 0.4
            u = u + SENSING.noise * draw.standard_normal(n)
            second = np.convolve(np.diff(x, 2) / SENSING.period**2, phi, "valid")
            first = np.convolve((x[2:] - x[:-2]) / (2.0 * SENSING.period), phi, "valid")
            ones = np.ones(second.size)
            rows.append(np.column_stack((second, first, sign * ones, ones)))
            right.append(np.convolve(u[1:-1], phi, "valid"))
        errors.append(
            np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0] - truth
        )
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert rms == pytest.approx(predicted, rel=0.15)


def test_sines_err_as_predicted() -> None:
    """Means of gated half sines with a white noise and counts at their ends, the regression written
    out: rms over draws."""
    facts = replace(
        facts_of(clutch(), AssessmentRequest(duration=10.0, noise=0.5)), inertia=(1.0, 1.0, 1.0)
    )
    draw, errors, axis = np.random.default_rng(7), [], facts.axis
    for _ in range(400):
        rows, right, weights = [], [], []
        for stroke in facts.strokes:
            count = int(2.0 * stroke.times)
            duration = stroke.duration * 2.0 / 3.0
            noise = facts.sensing.noise * math.sqrt(facts.sensing.period / duration)
            mean = stroke.speed * 3.0 * math.sqrt(3.0) / (2.0 * math.pi)
            ends = draw.uniform(-0.5, 0.5, (count, 2)) * facts.sensing.step
            seen = mean + (ends[:, 1] - ends[:, 0]) / duration
            rows.append(np.column_stack((seen, np.ones(count))))
            right.append(axis.viscous * mean + axis.coulomb + noise * draw.standard_normal(count))
            weights.append(
                np.full(
                    count,
                    1.0
                    / math.hypot(
                        noise, axis.viscous * facts.sensing.step / math.sqrt(6.0) / duration
                    ),
                )
            )
        weight = np.concatenate(weights)
        found = np.linalg.lstsq(
            np.vstack(rows) * weight[:, None], np.concatenate(right) * weight, rcond=None
        )[0]
        errors.append(found - [axis.viscous, axis.coulomb])
    assert np.sqrt(np.mean(np.square(errors), axis=0)) == pytest.approx(
        sines_half_width(facts, 1.0), rel=0.1
    )


def test_what_is_not_known_of_the_inertia_is_not_averaged_away() -> None:
    long = facts_of(clutch(), AssessmentRequest(duration=1e4))
    known = replace(long, inertia=(1.0, 1.0, 1.0))
    assert np.all(sines_half_width(long, 2.0) > 10.0 * sines_half_width(known, 2.0))


def test_ramps_err_as_predicted() -> None:
    rate, step, period, inertia = 0.1, 0.1, 1e-4, 1e-5
    draw = np.random.default_rng(6)
    late = rate * (6.0 * inertia * step * draw.uniform(0.0, 1.0, 100_000) / rate) ** (1.0 / 3.0)
    found = ramp_precision(rate, step, period, (inertia, inertia, inertia), 1.0)
    assert late.max() <= found.latest
    assert late.max() == pytest.approx(found.latest, rel=1e-3)
    assert found.deviation == pytest.approx(late.std(), rel=0.01)
    assert np.std(draw.uniform(0.0, 1.0, 100_000) ** (1.0 / 3.0)) == pytest.approx(SPREAD, rel=0.01)
    spread = ramp_precision(rate, step, period, (0.8 * inertia, inertia, 1.2 * inertia), 1e9)
    assert spread.deviation > 0.0  # the inertia's range is not averaged away


@pytest.mark.parametrize(("known", "precision"), [(0.9, WANTED), (0.01, 0.01)])
def test_auto_asks_for_the_wanted_precision_or_for_a_better_one_that_the_bench_has(
    known: float, precision: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    requested: list[float] = []

    def verdict(parameter: str, facts: AssessmentInputs, precision: float) -> SimpleNamespace:
        requested.append(precision)
        return SimpleNamespace(identifiable=True)

    monkeypatch.setattr(auto, "verdict", verdict)
    auto.decide_identifiability(
        "inertia", cast("AssessmentInputs", SimpleNamespace(known={"inertia": known}))
    )
    assert requested == [precision]
