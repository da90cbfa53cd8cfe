"""Metrics of a campaign's runs by kernels: equal to the functions of the metrics, bit by bit."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.campaign.draws.sampling import draws_of
from frictool.campaign.trials.trial_player import trial_of
from frictool.documents.conditions import ControllerCommand
from frictool.documents.metric_table import Rest
from frictool.documents.quantity import Quantity
from frictool.engine.closed_loop import COMMAND, MEASURED, RECORD_SIZE, TRUE_DRIVE
from frictool.engine.disturbances_and_faults import (
    NO_CONDITIONS,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    neutral,
)
from frictool.logs.quality.time_base import encoder_step
from frictool.metrics.drive_peak import command_peak
from frictool.metrics.final_value import final_value, tail_samples
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.response_time import response_time_95
from frictool.metrics.reversals import reversals
from frictool.report.run_kernels import OFF_LATTICE, lattice_distances, run_signals, step_metrics
from frictool.typing import Vector
from studies.rigs.campaign_rig import trial

STEP = 2.0 * math.pi / 500.0


def response(seed: int, samples: int, target: float) -> Vector:
    """Return counts of an underdamped response from 0 to `target` with a slow drift."""
    generator = np.random.Generator(np.random.PCG64(seed))
    t = np.arange(samples) / samples
    damping, turns, drift = generator.uniform([0.0, 0.1, -0.2], [40.0, 40.0, 0.2])
    exact = target * (1.0 - np.exp(-damping * t) * np.cos(2.0 * math.pi * turns * t) + drift * t)
    return np.floor(exact / STEP) * STEP


@given(
    seed=st.integers(0, 2**32),
    samples=st.integers(20, 3000),
    target=st.sampled_from([-50.0, -0.3, 0.1, 5.0]),
    resolution=st.sampled_from([0.0, STEP]),
)
def test_metrics_of_a_step(seed: int, samples: int, target: float, resolution: float) -> None:
    position, time = response(seed, samples, target), np.arange(samples) * 1e-3
    final, tail = final_value(position), tail_samples(samples)
    settled, overshoot, turns = step_metrics(position, 0.0, target, final, tail, resolution)
    expected = response_time_95(time, position, 0.0, target, resolution)
    assert (math.inf if settled < 0 else time[settled] - time[0]) == expected
    assert overshoot == overshoot_percent(position, 0.0, target, resolution)
    assert turns == reversals(position, 0.0, target, resolution)


@given(
    counts=st.lists(st.integers(-40, 40), min_size=1, max_size=60),
    multiple=st.integers(1, 4),
    lost=st.integers(-3, 3),
)
def test_sensor_step(counts: list[int], multiple: int, lost: int) -> None:
    """Lost counts are subtracted, so that equal positions differ by rounding."""
    position = np.array(counts) * multiple * STEP
    position[len(counts) // 2 :] -= lost * STEP
    distances, steps = lattice_distances(position, STEP)
    expected = encoder_step(position)
    assert steps != OFF_LATTICE
    found = float(distances.sum() / steps) if steps > 0.0 else None
    assert found == (expected if expected is None else pytest.approx(expected, rel=1e-14))


def test_positions_off_the_lattice_are_left_to_the_general_function() -> None:
    position = np.arange(20) * STEP
    for other, step in ((position + 0.3 * STEP, STEP), (position, 0.0), (position, STEP * 1e-9)):
        assert lattice_distances(other, step)[1] == OFF_LATTICE


def test_peak_of_the_command_and_measured_drive() -> None:
    generator = np.random.Generator(np.random.PCG64(1))
    noise = 0.1 * generator.normal(size=500)
    record = np.cumsum(0.1 * generator.normal(size=(500, RECORD_SIZE)), axis=0)
    conditions = neutral(500)
    conditions[:, SENSOR_GAIN], conditions[:, SENSOR_OFFSET] = 1.1, 0.3
    for rows, gain, offset in (
        (NO_CONDITIONS, 1.0, 0.0),
        (conditions, conditions[:, SENSOR_GAIN], conditions[:, SENSOR_OFFSET]),
    ):
        position, measured = np.empty(500), np.empty(500)
        command, finite = run_signals(record, rows, noise, position, measured)
        assert finite
        assert command == command_peak(record[:, COMMAND])
        np.testing.assert_array_equal(measured, gain * record[:, TRUE_DRIVE] + offset + noise)
        np.testing.assert_array_equal(position, record[:, MEASURED])
    for column in (MEASURED, COMMAND, TRUE_DRIVE):
        broken = record.copy()
        broken[7, column] = math.nan
        assert not run_signals(broken, NO_CONDITIONS, noise, position, measured)[1]


def test_outcomes_of_trials_are_those_of_judged_streams() -> None:
    """Only streams have the metrics of the last keys, and the fault after a command."""
    keys: list[dict[str, Any]] = [
        {"static_error": Quantity(value=1e-9, unit="rad"), "modulus_margin": 0.9},
        {"oscillations": 0, "overshoot_percent": 0.0, "drive_peak": Quantity(value=1.0, unit="A")},
        {"rest": Rest(9.0), "response_time_95_s": None},
        *({"rest": Rest(after, drive)} for after in (0.2, 0.02) for drive in (0.0, 10.0, 60.0)),
        {"drive_rms": Quantity(value=1.0, unit="A")},
    ]
    disabled = {"commands": (ControllerCommand("disable", 0.2),)}
    for number, (fields, changes) in enumerate([({}, one) for one in keys] + [(disabled, {})]):
        play = trial(**fields)
        spec = msgspec.structs.replace(play.setting.spec, **changes)
        play.setting = play.setting._replace(spec=spec)
        units = draws_of("random", 12, play.space.size, number).units
        for draw, unit in enumerate(units):
            scenario = play.scenario(unit, draw)
            assert repr(play.trial(draw, scenario)) == repr(trial_of(draw, play.judged(scenario)))
