"""Logs that identification refuses, each simulated: one reason, no model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from frictool.identify.axis_logs import sort_logs
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.force_error import motion_rows, predicted_by_position
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.measurement_faults import SELF_EXPLAINED, refuse_self_explained
from frictool.identify.methods import DEFAULT, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.sliding_parameters import LARGEST_FORCE_ERROR, sliding_fit
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, sines, steps
from tests.support.linear_axis import linear_axis, linear_bench

PERIOD = 1e-3


@pytest.fixture(scope="module")
def log() -> MotionRecord:
    return record(sines(3))


def reason(records: list[MotionRecord]) -> str:
    """Why nothing is identified from the records of the clutch; the same for each sliding
    parameter."""
    with pytest.raises(NothingIdentified) as raised:
        identify_records(records, [], clutch(), DEFAULT, IdentificationSettings())
    (why,) = {
        raised.value.result.refused[name] for name in ("inertia", "viscous", "coulomb", "offset")
    }
    assert "\n" not in why
    return why


def test_a_saturated_measurement(log: MotionRecord) -> None:
    top = 0.4 * float(np.abs(log.effort).max())
    assert "the measurement is saturated" in reason(
        [replace(log, effort=np.clip(log.effort, -top, top))]
    )


def test_an_effort_at_the_actuators_limit_is_known() -> None:
    """Steps drive the current into its limit, and the log shows what then acts."""
    full = record(steps(4))
    held = replace(
        full, effort=np.clip(2.0 * full.effort, -TRUTH.constant * 50.0, TRUTH.constant * 50.0)
    )
    with pytest.raises(NothingIdentified) as raised:
        identify_records(
            [replace(held, position=np.zeros(held.time.size))],
            [],
            clutch(),
            DEFAULT,
            IdentificationSettings(),
        )
    assert "saturated" not in raised.value.result.refused["coulomb"]


def test_a_clipped_encoder(log: MotionRecord) -> None:
    limit = float(np.quantile(log.position, 0.7))
    why = reason([replace(log, position=np.minimum(log.position, limit))])
    assert "the encoder is clipped" in why
    assert f"{limit:.4g} rad" in why


def moved(noise: float = 0.0) -> MotionRecord:
    """Return the output of a PD controller for an axis that is moved from outside.

    `noise` is the rms noise of the effort, relative to its rms value.
    """
    time = np.arange(20_000) * PERIOD
    exact = 20.0 * np.sin(2.0 * np.pi * 1.3 * time) * (1.0 + 0.3 * np.sin(0.6 * time))
    position = np.round(exact / 1e-5) * 1e-5
    command = 1e-4 * np.gradient(np.gradient(exact, PERIOD), PERIOD) + 2e-3 * np.gradient(
        exact, PERIOD
    )
    command += noise * np.std(command) * np.random.default_rng(0).standard_normal(time.size)
    return make_record("moved", time, position, command, resolution=1e-5, lag=0.003)


def test_a_controllers_own_output() -> None:
    why = reason([moved()])
    assert "computed from the encoder" in why
    assert "log the measured current" in why


def test_output_error_recognises_a_controllers_own_output() -> None:
    with pytest.raises(UnusableLogs, match="computed from the encoder"):
        run("output-error", [moved()], clutch(), IdentificationSettings())


def test_an_effort_with_noise_was_measured() -> None:
    """The smoothing leaves little of the noise: without friction, the fit explains nearly all."""
    record = moved(noise=2e-3)
    fit = run("least-squares", [record], clutch(), IdentificationSettings())
    assert fit.residual < SELF_EXPLAINED
    refuse_self_explained(fit, [record])


def test_a_load_that_no_model_contains() -> None:
    """Constant speeds from free travel into a contact; a model without it explains little."""
    period = 1e-3
    speeds = np.repeat([20.0, 40.0, 60.0, 80.0, 100.0], 2) * np.tile([1.0, -1.0], 5)
    velocity = np.repeat(speeds, (20.0 / np.abs(speeds) / period).astype(int))
    position = np.cumsum(velocity) * period
    contact = 0.06 * np.maximum(position - 14.0, 0.0) ** 2
    noise = 0.01 * np.random.default_rng(1).standard_normal(position.size)
    effort = 0.03 * np.sign(velocity) + contact + noise
    time = np.arange(position.size) * period
    record = make_record("contact", time, position, effort, resolution=1e-3, lag=0.0)
    logs = sort_logs([record], [], clutch(), DEFAULT, IdentificationSettings())
    with pytest.raises(UnusableLogs, match=r"explain the effort: .* a load over the position"):
        sliding_fit(logs)
    # a load that belongs to another test is no function of the position
    other = replace(record, effort=np.roll(effort, position.size // 3))
    assert predicted_by_position(motion_rows([other], clutch())) > LARGEST_FORCE_ERROR


def test_a_measured_effort_on_a_fine_encoder_is_not_its_own_output() -> None:
    truth, axis = linear_axis(2)
    found = identify_records(
        [axis], [], linear_bench(), "least-squares", IdentificationSettings()
    ).identified["coulomb"]
    assert found.low <= truth.coulomb <= found.high


def test_too_few_reversals() -> None:
    """The first strokes of the linear axis: one backward stroke tells no difference of directions
    from one of strokes."""
    _, axis = linear_axis(2)
    strokes = slice(0, 640)
    short = make_record(
        "short",
        axis.time[strokes],
        axis.position[strokes],
        axis.effort[strokes],
        axis.resolution,
        axis.lag,
    )
    fit = run("least-squares", [short], linear_bench(), IdentificationSettings())
    for name in ("coulomb", "offset"):
        assert "too few reversals" in fit.refused[name]
        assert name not in fit.parameters


def test_no_excitation() -> None:
    still = make_record(
        "still",
        np.arange(3000) * PERIOD,
        np.zeros(3000),
        np.ones(3000) * 0.05,
        TRUTH.encoder_step,
        0.003,
    )
    assert "never moves by more than one encoder count" in reason([still])
