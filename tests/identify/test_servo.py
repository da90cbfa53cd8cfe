"""Identification of smart servos from goals and positions, against servos simulated without it."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.identify.from_logs import IdentifiedModel, identify
from frictool.identify.methods import IdentificationRequest
from frictool.logs.log_reader import read_log
from frictool.typing import IntVector
from studies.command_line import run
from tests.identify.servo_bench import BENCH, COUNT, PERIOD, ServoLogs, SmartServo, drawn_servo
from tests.identify.servo_bench import recorded as recorded_logs
from tests.support.command_line import refused

AXIS = ("inertia", "viscous", "coulomb")
CONSTANTS = ("constant", "goal_speed", "delay", "back_emf", "zero")


@cache
def logs_of(seed: int) -> tuple[SmartServo, ServoLogs]:
    """A drawn servo and its logs."""
    generator = np.random.default_rng(seed)
    servo = drawn_servo(generator)
    return servo, recorded_logs(servo, generator)


def part_of(logs: ServoLogs, chosen: IntVector) -> ServoLogs:
    """The logs with the numbers `chosen`."""
    rows = (getattr(logs, name)[chosen] for name in vars(logs) if name != "time")
    return ServoLogs(logs.time, *rows)


def bench_in(folder: Path, text: str = BENCH) -> Bench:
    """The bench of the servos, from a file."""
    path = folder / "bench.yaml"
    path.write_text(text, encoding="utf-8")
    return load(path, Bench)


def identified(logs: ServoLogs, folder: Path, text: str = BENCH) -> IdentifiedModel:
    """The model of the logs."""
    bench = bench_in(folder, text)
    return identify([read_log(path, bench) for path in logs.write(folder)], bench)


def intervals(outcome: IdentifiedModel) -> dict[str, tuple[float, float]]:
    """The intervals of all identified values."""
    assert outcome.result.fit is not None
    known = {name: (one.low, one.high) for name, one in outcome.result.identified.items()}
    return known | {name: one.interval for name, one in outcome.result.fit.constants.items()}


@pytest.mark.parametrize(
    ("servos", "least"), [(1, 6), pytest.param(4, 27, marks=pytest.mark.accept)]
)
def test_intervals_contain_the_truth(tmp_path: Path, servos: int, least: int) -> None:
    """95 % intervals: fewer than 6 of 8, or 27 of 32, have a probability of 0.6 or 0.4 %."""
    inside = 0
    for seed in range(servos):
        servo, logs = logs_of(seed)
        logs = part_of(logs, np.arange(5))  # of all kinds
        outcome = identified(logs, tmp_path)
        assert not any("between the encoder's counts" in text for text in outcome.result.warnings)
        found = intervals(outcome)
        assert found.keys() >= {*AXIS, *CONSTANTS}
        inside += sum(
            found[name][0] <= getattr(servo, name) <= found[name][1] for name in (*AXIS, *CONSTANTS)
        )
        for name in ("inertia", "viscous", "constant", "goal_speed", "delay", "back_emf"):
            low, high = found[name]
            assert high - low < 0.2 * getattr(servo, name), name
    assert inside >= least


def test_without_a_free_swing_the_back_emf_is_refused(tmp_path: Path) -> None:
    servo, logs = logs_of(0)
    outcome = identified(part_of(logs, np.array([0, 1, 2, 4])), tmp_path)
    assert outcome.result.refused["back_emf"] == (
        "no log moves with its torque disabled; record a free swing"
    )
    found = intervals(outcome)
    assert "back_emf" not in found
    for name in ("viscous", "constant", "delay", "goal_speed"):
        low, high = found[name]
        assert low <= getattr(servo, name) <= high, name


@pytest.mark.accept
def test_interpolated_positions_are_named(tmp_path: Path) -> None:
    """Positions at half of the rate, interpolated between the counts, as some loggers write."""
    servo, logs = logs_of(1)
    kept = np.arange(0, logs.time.size, 2)
    at = logs.time + 0.3 * PERIOD
    position = np.array([np.interp(at, logs.time[kept], one[kept]) for one in logs.position])
    whole = np.abs(position / COUNT - np.round(position / COUNT)) < 1e-6
    assert np.mean(whole) < 0.7
    coarse = replace(logs, time=logs.time, position=position)
    outcome = identified(coarse, tmp_path)
    assert any("between the encoder's counts" in text for text in outcome.result.warnings)
    low, high = intervals(outcome)["constant"]
    assert low <= servo.constant <= high


@pytest.mark.accept
def test_without_a_pendulum_gravity_is_fitted_relative_to_the_constant(tmp_path: Path) -> None:
    servo = SmartServo()
    generator = np.random.default_rng(3)
    logs = recorded_logs(servo, generator)
    same = logs.mass * logs.length == np.median(logs.mass * logs.length)
    assert np.sum(same) >= 2
    text = "\n".join(
        line for line in BENCH.splitlines() if not line.startswith("  pendulum_")
    ).replace("{value: 0.4, low: 0.1, high: 2, unit: N m/V}", "{value: 0.5, unit: N m/V}")
    part = part_of(logs, np.flatnonzero(same))
    outcome = identified(part, tmp_path, text)
    laws = outcome.model.laws
    assert laws is not None
    assert laws.load is not None
    assert laws.load.gravity is not None
    torque = float(part.mass[0] * part.length[0]) * 9.80665
    low, high = laws.load.gravity.sine.interval
    assert low <= torque * np.cos(servo.zero) <= high
    assert "constant" not in intervals(outcome)


def test_validation_simulates_along_the_goal(tmp_path: Path) -> None:
    """The model of two logs predicts another to within two counts (rms)."""
    _, logs = logs_of(0)
    paths = logs.write(tmp_path)
    bench_in(tmp_path)
    model = tmp_path / "model.yaml"
    run("identify", paths[1], paths[3], "--bench", tmp_path / "bench.yaml", "-o", model)
    shown = json.loads(run("validate", model, paths[6], "--cutoff-hz", "10", "--json").stdout)
    assert shown["loop"] == "servo"
    assert shown["position_rmse_rad"] < 2.0 * COUNT
    gains = ("--position-gain", "1", "--speed-gain", "1")
    refused(run("validate", model, paths[6], *gains), 3, "is the controller; leave the gains out")


def test_a_goal_speed_that_no_goal_reaches_is_refused(tmp_path: Path) -> None:
    """The sines of these logs need 3.7 rad/s, less than the limit of the firmware."""
    servo, logs = logs_of(0)
    assert servo.goal_speed > 4.0
    outcome = identified(part_of(logs, np.array([1, 5])), tmp_path)
    assert "record faster goals" in outcome.result.refused["goal_speed"]
    found = intervals(outcome)
    assert "goal_speed" not in found
    assert found["delay"][0] <= servo.delay <= found["delay"][1]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("  gain: {column: kp, unit: '1'}\n", "", "write actuator.servo.gain"),
        ("  reference: {column: goal, unit: rad}\n", "", "the goal of the servo; map the column"),
        ("position, unit: rad}", "position, unit: rad, scale: -1}", "misses .* of the motion"),
        (
            "{column: torque_enable, unit: '1'}",
            "{column: torque_enable, unit: '1', scale: 0}",
            "with its torque enabled",
        ),
    ],
)
def test_refusals_name_the_key(tmp_path: Path, old: str, new: str, reason: str) -> None:
    _, logs = logs_of(0)
    assert old in BENCH
    with pytest.raises(FrictoolError, match=reason):
        identified(part_of(logs, np.array([0, 3])), tmp_path, BENCH.replace(old, new))


def test_a_method_that_needs_an_effort_is_refused(tmp_path: Path) -> None:
    _, logs = logs_of(0)
    bench = bench_in(tmp_path)
    read = [read_log(path, bench) for path in logs.write(tmp_path)]
    with pytest.raises(FrictoolError, match="allowed: auto, output-error"):
        identify(read, bench, IdentificationRequest("least-squares"))


def test_a_servo_needs_a_voltage(tmp_path: Path) -> None:
    text = BENCH.replace("drive: voltage", "drive: current").replace("N m/V}", "N m/A}")
    with pytest.raises(FrictoolError, match="`servo` is for `drive: voltage`"):
        bench_in(tmp_path, text.replace("unit: V}\n  servo", "unit: A}\n  servo"))
