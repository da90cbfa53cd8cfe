"""An effort that stays constant while the axis changes its speed was not measured; steps, coasting
and coarse currents are kept."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.constant_effort import constant_stretches
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.typing import Vector
from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.measured_data import data

TIME = np.arange(12_000) * PERIOD
LIGHT = Arm(counts=65536)  # no gravity
GRAVITY = "load: {terms: [offset, gravity]}\n"


def sines(scale: float = 1.0) -> Vector:
    """An effort (n,) in N m of three sines that moves the arm to and fro."""
    return scale * sum(
        a * np.sin(2.0 * np.pi * f * TIME + p)
        for a, f, p in ((0.8, 0.5, 0.0), (0.5, 0.83, 1.0), (0.4, 1.37, 2.0))
    )


def noisy(effort: Vector, seed: int) -> Vector:
    return effort + 0.01 * np.random.default_rng(seed).standard_normal(effort.size)


@pytest.mark.parametrize(("level", "load_line"), [(0.9, GRAVITY), (1.3, ""), (-0.6, GRAVITY)])
def test_an_arm_that_swings_under_a_constant_effort_is_refused(
    tmp_path: Path, level: float, load_line: str
) -> None:
    """The effort is true, and yet it says nothing: an offset of its size explains it to the last
    digit."""
    arm = Arm(coulomb=0.02, breakaway=0.022, viscous=0.01, gravity=3.3, counts=65536)
    position, effort = play(arm, np.full(TIME.size, level))
    log, bench = (
        write_log(tmp_path / "held.csv", position, noisy(effort, 1)),
        write_bench(tmp_path, arm, load_line),
    )
    model = tmp_path / "model.yaml"
    result = run("identify", log, "--bench", bench, "--method", "least-squares", "-o", model)
    assert result.code == 1
    stays = re.search(
        r"held.csv: the effort stays near (\S+) N m for (\d+) % of the motion", result.stderr
    )
    assert stays is not None, result.stderr
    assert float(stays[1]) == pytest.approx(level, rel=0.1)
    assert int(stays[2]) > 50
    assert not model.exists()


def test_a_channel_that_freezes_is_left_out_from_there_on(tmp_path: Path) -> None:
    position, effort = play(LIGHT, sines())
    effort = noisy(effort, 2)
    frozen = np.where(TIME > 8.0, effort[8000], effort)
    log, bench = write_log(tmp_path / "frozen.csv", position, frozen), write_bench(tmp_path, LIGHT)
    result = run("identify", log, "--bench", bench, "--method", "least-squares", "--json")
    assert result.code == 0, result.stderr
    assert "these samples are left out" in result.stderr
    found = json.loads(result.stdout)["parameters"]
    for name in ("inertia", "coulomb"):
        assert found[name]["low"] <= getattr(LIGHT, name) <= found[name]["high"], name


def record(position: Vector, effort: Vector, arm: Arm = LIGHT) -> MotionRecord:
    return make_record("log", np.arange(position.size) * PERIOD, position, effort, arm.step, 0.0)


def bench_of(folder: Path, arm: Arm = LIGHT) -> Bench:
    return load(write_bench(folder, arm), Bench)


def test_what_a_constant_effort_does_say_is_kept(tmp_path: Path) -> None:
    """Steps of several levels, and an axis that is pushed and coasts."""
    bench = bench_of(tmp_path)
    levels = np.repeat([0.5, -0.7, 0.9, -0.5, 0.7, -0.9, 0.6, -0.8], 1500)
    assert constant_stretches(record(*play(LIGHT, levels)), bench)[0] == []
    pushes = np.tile(
        np.concatenate((np.full(300, 1.0), np.zeros(1200), np.full(300, -1.0), np.zeros(1200))), 4
    )
    assert constant_stretches(record(*play(LIGHT, pushes)), bench)[0] == []


def test_an_arm_that_swings_under_three_constant_efforts_is_kept(tmp_path: Path) -> None:
    """Each effort holds through several strokes and changes the acceleration; one level would be a
    saturated measurement, three are steps."""
    arm = Arm(coulomb=0.02, breakaway=0.022, viscous=0.01, gravity=3.3, counts=65536)
    swing = record(*play(arm, np.repeat([0.5, 1.3, 0.9], 4000)), arm)
    assert constant_stretches(swing, bench_of(tmp_path, arm))[0] == []


@pytest.mark.parametrize("seed", range(4))
def test_a_current_of_few_steps_against_dry_friction_is_kept(tmp_path: Path, seed: int) -> None:
    """A coarse converter shows a constant effort if friction takes nearly all of it; such a log is
    no error."""
    draw = np.random.default_rng(seed)
    friction = draw.uniform(2.0, 6.0)
    arm = Arm(inertia=0.02, viscous=0.01, coulomb=friction, breakaway=1.05 * friction, counts=65536)
    position, effort = play(
        arm, 0.5 * np.sin(2.0 * np.pi * draw.uniform(0.3, 0.6) * TIME), (400.0, 800.0, 4.0)
    )
    coarse = np.round(effort / (0.1 * friction)) * 0.1 * friction
    assert constant_stretches(record(position, coarse, arm), bench_of(tmp_path, arm))[0] == []


def test_servo_motions_are_kept(tmp_path: Path) -> None:
    bench = bench_of(tmp_path)
    for seed in range(4):
        phase = np.random.default_rng(seed).uniform(0.0, 6.0)
        position, effort = play(
            LIGHT, 0.5 * np.sin(4.0 * TIME + phase) + 0.2 * np.sin(1.3 * TIME), (60.0, 100.0, 3.0)
        )
        assert constant_stretches(record(position, noisy(effort, seed)), bench)[0] == []


@pytest.mark.parametrize(
    ("name", "period", "method"),
    [
        ("gravity_compensation", 0.001, "least-squares"),
        ("pd__1nm_torque_limited_swingup_failure", 0.005, "auto"),
        pytest.param("gravity_compensation", 0.001, "auto", marks=pytest.mark.accept),
        pytest.param(
            *("pd__1nm_torque_limited_swingup_failure", 0.005, "least-squares"),
            marks=pytest.mark.accept,
        ),
    ],
)
def test_measured_pendulum_logs_of_a_held_torque_are_refused(
    tmp_path: Path, name: str, period: float, method: str
) -> None:
    log = data("field", "dfki", f"control_method_{name}__data_measured.csv")
    pendulum = Arm(inertia=0.17, viscous=0.05, coulomb=0.1, counts=2156)
    bench = write_bench(tmp_path, pendulum, GRAVITY)
    bench.write_text(
        bench.read_text()
        .replace("column: current", "column: torque")
        .replace("_s: 0.001", f"_s: {period}")
    )
    assert run(
        "identify", log, "--bench", bench, "--method", method, "-o", tmp_path / "m.yaml"
    ).code in (1, 4)
    assert not (tmp_path / "m.yaml").exists()
