"""Every method on simulated logs: known parameters come back, and what makes each of them differ
shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from frictool.errors import FrictoolError
from frictool.identify.applicable_methods import _no_sliding, _too_rough
from frictool.identify.estimators.total_least_squares import errors_in_variables
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord
from frictool.logs.quality.survey import POSITION
from studies.rigs.identification_rigs import (
    MASS,
    clutch,
    mass_bench,
    mass_reference,
    mass_sine,
    record,
)
from studies.rigs.sample_logs import TRUTH, sines

UNBIASED = [
    "auto",
    "least-squares",
    "power-balance",
    "weighted",
    "conditioned",
    "weak",
    "instrumental",
    "total-least-squares",
    "recursive",
]


@pytest.fixture(scope="module")
def log() -> MotionRecord:
    return replace(mass_sine(11), reference=mass_reference(11))


@pytest.mark.parametrize("method", UNBIASED)
def test_known_parameters_of_the_mass(method: str, log: MotionRecord, tmp_path: Path) -> None:
    fit = run(method, [log], mass_bench(tmp_path), IdentificationSettings(confidence=0.999))
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.parameters[name].low <= getattr(MASS, name) <= fit.parameters[name].high
    assert fit.parameters["coulomb"].half_width < 0.03
    assert fit.residual == pytest.approx(fit.held_out_residual, rel=0.05)


def test_equal_weights_are_the_narrowest_under_an_even_noise(
    log: MotionRecord, tmp_path: Path
) -> None:
    bench = mass_bench(tmp_path)
    even, by_speed = (
        run(method, [log], bench, IdentificationSettings())
        for method in ("least-squares", "power-balance")
    )
    assert even.parameters["coulomb"].half_width < 0.85 * by_speed.parameters["coulomb"].half_width


def test_weights_follow_the_noise(log: MotionRecord, tmp_path: Path) -> None:
    """The slow half of the samples gets ten times the noise: weighted narrows, equal weights do not
    know."""
    slow = np.abs(np.gradient(log.position, log.period)) < 5.0
    noisy = replace(
        log,
        effort=log.effort
        + np.where(slow, 1.0, 0.0) * np.random.default_rng(3).standard_normal(log.effort.size),
    )
    bench = mass_bench(tmp_path)
    even, weighted = (
        run(method, [noisy], bench, IdentificationSettings())
        for method in ("least-squares", "weighted")
    )
    assert weighted.parameters["viscous"].half_width < 0.6 * even.parameters["viscous"].half_width
    assert weighted.parameters["viscous"].low <= MASS.viscous <= weighted.parameters["viscous"].high


def test_noise_of_the_encoder_attenuates_the_inertia_but_where_it_is_accounted_for(
    log: MotionRecord, tmp_path: Path
) -> None:
    """Five counts of noise and the shortest window: a known loss for least squares, none with
    instruments or total least squares."""
    noise = 5e-4 * np.random.default_rng(5).standard_normal(log.position.size)
    noisy, bench = replace(log, position=log.position + noise), mass_bench(tmp_path)
    found = {
        m: run(m, [noisy], bench, IdentificationSettings(window=11))
        for m in ("least-squares", "total-least-squares", "instrumental")
    }
    ratio = {method: _inertia(fit) / MASS.inertia for method, fit in found.items()}
    assert ratio["least-squares"] < 0.8
    assert ratio["total-least-squares"] == pytest.approx(1.0, abs=0.1)
    assert ratio["instrumental"] == pytest.approx(1.0, abs=0.2)


def _inertia(fit: SlidingFit) -> float:
    return fit.parameters["inertia"].value


def test_instruments_need_a_reference_that_the_axis_followed(
    log: MotionRecord, tmp_path: Path
) -> None:
    with pytest.raises(UnusableLogs, match="has no reference"):
        run("instrumental", [record(sines(1))], clutch(), IdentificationSettings())
    with pytest.raises(UnusableLogs, match="the reference stands still while the axis moves"):
        run(
            "instrumental",
            [replace(log, reference=np.zeros(log.position.size))],
            mass_bench(tmp_path),
            IdentificationSettings(),
        )
    with pytest.raises(UnusableLogs, match="does not follow"):
        run(
            "instrumental",
            [replace(log, reference=-log.position)],
            mass_bench(tmp_path),
            IdentificationSettings(),
        )


def test_total_least_squares_removes_a_known_noise() -> None:
    draw = np.random.default_rng(2)
    true = draw.normal(size=(200_000, 2))
    seen = true + draw.normal(size=true.shape) * [0.5, 0.0]
    target = true @ [2.0, -1.0] + 0.3 * draw.normal(size=true.shape[0])
    rows = np.column_stack((seen, target))
    found = errors_in_variables(rows.T @ rows / rows.shape[0], np.diag([0.25, 0.0, 0.09]))
    assert found == pytest.approx([2.0, -1.0], abs=0.02)
    assert np.linalg.lstsq(seen, target, rcond=None)[0][0] < 1.7


def test_auto_takes_equal_weights_where_friction_is_viscous_and_coulomb(
    log: MotionRecord, tmp_path: Path
) -> None:
    fit = run("auto", [log], mass_bench(tmp_path), IdentificationSettings())
    assert fit.method == "least-squares"
    assert "agree" in str(fit.why)


def test_auto_takes_the_power_balance_where_friction_falls_over_speed() -> None:
    """A Stribeck effect that reaches far beyond the slip mask, put into the effort of a log of the
    clutch."""
    log = record(sines(1, fine := TRUTH._replace(encoder_step=2e-4, backlash=0.0)), fine)
    speed = np.gradient(log.position, log.period)
    falling = replace(
        log, effort=log.effort + 0.05 * np.exp(-((speed / 30.0) ** 2)) * np.sign(speed)
    )
    fit = run("auto", [falling], clutch(), IdentificationSettings())
    assert fit.method == "power-balance"
    even = run("least-squares", [falling], clutch(), IdentificationSettings())
    assert abs(fit.parameters["coulomb"].value - TRUTH.coulomb) < abs(
        even.parameters["coulomb"].value - TRUTH.coulomb
    )


def test_auto_drops_an_offset_that_is_none_and_keeps_one_that_is(tmp_path: Path) -> None:
    dropped = [
        run("auto", [mass_sine(seed)], mass_bench(tmp_path), IdentificationSettings())
        for seed in range(2)
    ]
    assert any(fit.dropped == ("offset",) for fit in dropped)
    for fit in dropped:
        if fit.dropped:
            assert fit.parameters["offset"].value == 0.0
            assert fit.parameters["offset"].low < 0.0 < fit.parameters["offset"].high
    assert run("auto", [record(sines(1))], clutch(), IdentificationSettings()).dropped == ()


@pytest.mark.parametrize("method", ["ordinary", "threshold", "weak", "instrumental", "recursive"])
def test_no_motion_is_said(method: str) -> None:
    log = record(sines(1))
    still = replace(log, position=np.zeros(log.time.size), reference=np.zeros(log.time.size))
    with pytest.raises(FrictoolError, match=r"slip|moves|motion") as raised:
        run(method, [still], clutch(), IdentificationSettings())
    assert isinstance(raised.value, UnusableLogs)


def test_a_coarse_encoder_is_told_with_its_share_of_a_sample_distance() -> None:
    """0.4 rad/s at 100 Hz is 4 mrad per sample, and a count of 2 mrad half of it."""
    stream: Any = SimpleNamespace(
        base=SimpleNamespace(gaps=0, rate_hz=100.0),
        signals={POSITION: SimpleNamespace(step=2e-3)},
        velocity=(-0.4, 0.3),
    )
    assert "one encoder count is 50 % of the distance per sample" in str(_too_rough(stream))
    stream.velocity = None
    assert _too_rough(stream) is None


@pytest.mark.parametrize("velocity", [(0.0, 0.4), (-0.4, 0.0), (0.1, 0.4)])
def test_one_direction_and_rests_do_not_reveal_an_offset(velocity: tuple[float, float]) -> None:
    stream: Any = SimpleNamespace(velocity=velocity)
    assert "moves in one direction only" in str(_no_sliding(stream, "sines"))
    stream.velocity = (-0.1, 0.4)
    assert _no_sliding(stream, "sines") is None
