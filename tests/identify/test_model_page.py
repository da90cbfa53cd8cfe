"""`identify --page`: the data behind the figures of a model's page."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from frictool.identify.model_page.evidence import (
    HeldOutPositions,
    PositionPrediction,
    SlipSamples,
    friction_over_speed,
    position_spectrum,
)
from frictool.identify.model_page.friction_panels import band_half_width
from frictool.identify.text_view import parameter_lines
from frictool.typing import Vector

ROOT = Path(__file__).parents[2]
NONLINEAR = load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model)


def samples(position: Vector, residual: Vector) -> SlipSamples:
    velocity = np.asarray((-1.0) ** np.arange(position.size))
    time = np.asarray(np.arange(position.size) * 1e-3)
    return SlipSamples(time, position, velocity, residual, residual)


def test_a_ripple_is_found_in_the_spectrum_at_its_wave_number_and_amplitude() -> None:
    position = np.asarray(np.linspace(0.0, 4.0 * np.pi, 20_000))
    numbers, amplitudes = position_spectrum(samples(position, 0.05 * np.sin(7.0 * position))) or (
        np.empty(0),
        np.empty(0),
    )
    largest = int(np.argmax(amplitudes))
    assert 2.0 * np.pi * numbers[largest] == pytest.approx(7.0, abs=0.15)
    assert amplitudes[largest] == pytest.approx(0.05, rel=0.05)


def test_a_travel_of_few_cells_has_no_spectrum() -> None:
    assert position_spectrum(samples(np.zeros(100), np.ones(100))) is None


def test_the_fit_is_100_for_equal_positions_and_0_for_the_mean() -> None:
    time = np.arange(100.0)
    wave = np.sin(time)
    for simulated, fit in ((wave, 100.0), (np.full(100, wave.mean()), 0.0)):
        held_out = HeldOutPositions(True, (PositionPrediction("a", time, wave, simulated),))
        assert held_out.fit == pytest.approx(fit)


def test_the_text_has_absolute_intervals_if_the_constant_has_an_interval() -> None:
    """The clutch's constant is 13.4 in [12.8, 14.0] mN m/A; the bench's inertia needs none."""
    found = {
        name: Estimate(0.1, 0.09, 0.12, "N m", source="identified")
        for name in ("coulomb", "offset", "breakaway")
    }
    parameters = msgspec.structs.replace(NONLINEAR.parameters, **found)
    model = msgspec.structs.replace(NONLINEAR, parameters=parameters)
    constant = model.bench.actuator.constant
    head, inertia, viscous, *rows = parameter_lines(model)
    assert "absolute interval" in head
    assert inertia.count("[1.11e-05, 1.53e-05]") == 2
    assert viscous.count("unknown") == 2
    low, high = absolute(0.09, 0.12, constant)
    assert len(rows) == 3
    shown = f"[0.09, 0.12] [{low:.5g}, {high:.5g}] N m"
    assert all(shown in " ".join(row.split()) for row in rows)
    exact = msgspec.structs.replace(constant, low=None, high=None)
    actuator = msgspec.structs.replace(model.bench.actuator, constant=exact)
    bench = msgspec.structs.replace(model.bench, actuator=actuator)
    assert "absolute" not in parameter_lines(msgspec.structs.replace(model, bench=bench))[0]


def test_the_band_is_that_of_a_regression_line() -> None:
    """A line fitted to samples at these speeds: its standard error, from the covariance of its two
    coefficients, is the band that follows from their two standard errors alone."""
    speeds = np.linspace(1.0, 9.0, 400)
    covariance = np.linalg.inv(
        (columns := np.column_stack([np.ones_like(speeds), speeds])).T @ columns
    )
    today = NONLINEAR.parameters
    half = np.sqrt(np.diag(covariance))

    def around(estimate: Estimate, reach: float) -> Estimate:
        return Estimate(
            estimate.value,
            estimate.value - reach,
            estimate.value + reach,
            estimate.unit,
            source="identified",
        )

    parameters = msgspec.structs.replace(
        today, coulomb=around(today.coulomb, half[0]), viscous=around(today.viscous, half[1])
    )
    model = msgspec.structs.replace(NONLINEAR, parameters=parameters)
    at = np.array([0.0, 3.0, 12.0])
    rows = np.column_stack([np.ones(3), at])
    exact = np.sqrt(np.einsum("ij,jk,ik->i", rows, covariance, rows))
    slip = samples(speeds, speeds)
    slip = SlipSamples(slip.time, slip.position, speeds, slip.residual, slip.friction)
    assert band_half_width(model, slip, at) == pytest.approx(exact, rel=1e-6)


def test_the_curve_falls_from_the_breakaway_where_the_model_has_a_stribeck_velocity() -> None:
    today = NONLINEAR.parameters
    fall = Estimate(1.0, 0.9, 1.1, "rad/s", source="identified")
    stribeck = msgspec.structs.replace(
        NONLINEAR,
        law="stribeck",
        parameters=msgspec.structs.replace(today, stribeck_velocity=fall),
    )
    curve = friction_over_speed(stribeck, np.array([0.0, 20.0]), 1.0)
    plain = friction_over_speed(NONLINEAR, np.array([0.0, 20.0]), 1.0)
    assert curve[0] == pytest.approx(plain[0] + today.breakaway.value - today.coulomb.value)
    assert curve[1] == pytest.approx(plain[1])
