"""The judge of studies/actuators against closed forms, and against `frictool simulate`."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp

from frictool.adapters.parameter_intervals import ranges
from frictool.documents.writing import save
from frictool.logs.log_reader import read_log
from frictool.plant.polytope import corner_points
from frictool.typing import Vector
from studies.actuators.drawing import VARIED, Actuator, Interval, Plant, draw, draw_plants
from studies.actuators.judge import Run, axis_record, hold_figures, play
from studies.actuators.margin import cascade_margin, loop_margin, margin, sampled_axis
from studies.actuators.native import judge_library, load_exported
from studies.actuators.search import search
from studies.command_line import run_checked
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from studies.rigs.verified_controller import truthful

FIELDS = (
    "period", "delay", "lag", "step", "limit", "inertia", "viscous", "coulomb", "constant",
    "breakaway", "backlash", "loose", "loose_breakaway", "start",
)  # fmt: skip
POSITION, SPEED, DRIVE, GAP = range(4)


def axis(**values: float) -> Vector:
    """An axis of inertia 2 and constant 3 without lag, friction and backlash, but for `values`."""
    given = {"period": 1e-3, "step": 1e-6, "limit": 10.0, "inertia": 2.0, "constant": 3.0, **values}
    return np.array([given.get(name, 0.0) for name in FIELDS])


def moved(
    record: Vector, motion: Vector, command: float, duration: float, parts: int = 1
) -> Vector:
    """The motion (position, speed, drive, gap) after a constant command."""
    motion = motion.copy()
    for _ in range(parts):
        code = judge_library().axis_move(
            record.ctypes.data, motion.ctypes.data, command, duration / parts
        )
        assert code == 0
    return motion


def test_the_axis_sticks_below_its_breakaway_and_slips_above() -> None:
    rough = axis(coulomb=5.0, breakaway=6.0)
    at_rest = np.zeros(4)
    assert moved(rough, at_rest, 1.999, 10.0)[POSITION] == 0.0
    slipped = moved(rough, at_rest, 2.001, 1.0)
    assert slipped[SPEED] == pytest.approx((3.0 * 2.001 - 5.0) / 2.0, rel=1e-12)


def test_a_sliding_axis_stops_at_its_closed_form_and_stays() -> None:
    """J v' = -F - s v from v0: stops after J/s ln(1 + s v0/F)."""
    sliding, start = axis(coulomb=0.5, breakaway=0.6, viscous=0.8), np.array([0.0, 3.0, 0.0, 0.0])
    time = 2.0 / 0.8 * math.log(1.0 + 0.8 * 3.0 / 0.5)
    distance = 2.0 / 0.8 * 3.0 - 0.5 / 0.8 * time
    assert moved(sliding, start, 0.0, 0.999 * time)[SPEED] > 0.0
    ended = moved(sliding, start, 0.0, 2.0 * time)
    assert ended[SPEED] == 0.0
    assert ended[POSITION] == pytest.approx(distance, rel=1e-12)


def test_the_lag_of_the_drive() -> None:
    """J v' = K u (1 - exp(-t/lag)), breakaway at t = -lag ln(1 - F/(K u))."""
    lag, friction, time = 0.2, 6.0, 1.0
    lagging = axis(lag=lag, coulomb=friction, breakaway=friction)
    start = -lag * math.log(1.0 - friction / 30.0)
    ended = moved(lagging, np.zeros(4), 10.0, time)
    speed = (
        24.0 * (time - start) - 30.0 * lag * (math.exp(-start / lag) - math.exp(-time / lag))
    ) / 2.0
    assert ended[DRIVE] == pytest.approx(10.0 * (1.0 - math.exp(-time / lag)), rel=1e-12)
    assert ended[SPEED] == pytest.approx(speed, rel=1e-12)


def test_bang_bang() -> None:
    """Half of the time forward and half backward: distance K u T^2/(4 J), at rest."""
    there = moved(axis(), np.zeros(4), 10.0, 0.5)
    back = moved(axis(), there, -10.0, 0.5)
    assert back[POSITION] == pytest.approx(15.0 * 0.25, rel=1e-12)
    assert back[SPEED] == pytest.approx(0.0, abs=1e-12)


def test_the_backlash_is_crossed_with_its_own_friction() -> None:
    """From the middle: half the width with the loose friction, then with the axis's friction."""
    slack = axis(
        backlash=1.0, loose=1.0, loose_breakaway=1.1, coulomb=9.0, breakaway=9.5, viscous=4.0
    )
    reached = moved(slack, np.zeros(4), 1.0, 1.0)  # (3 - 1)/2 t^2/2 = 0.5
    assert reached[[POSITION, SPEED, GAP]] == pytest.approx([0.5, 1.0, 0.5], rel=1e-9)
    loaded = moved(slack, reached, 1.0, 0.1)
    slowed = solve_ivp(lambda _, v: (3.0 - 9.0 - 4.0 * v) / 2.0, (0, 0.1), [1.0], rtol=1e-10)
    assert loaded[SPEED] == pytest.approx(slowed.y[0, -1], rel=1e-6)
    stopped = moved(slack, reached, 1.0, 5.0)
    assert stopped[SPEED] == 0.0
    assert stopped[GAP] == 0.5
    assert moved(slack, stopped, 0.36, 5.0)[POSITION] == stopped[POSITION]
    assert moved(slack, stopped, -0.37, 5.0)[POSITION] < stopped[POSITION]


def test_parts_of_a_sample_give_the_whole() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        record = axis(
            lag=float(rng.choice([0.0, 0.03, 0.5])), coulomb=float(rng.uniform(0.5, 4.0)),
            breakaway=4.4, viscous=float(rng.choice([0.0, 1.0, 4.0])), backlash=0.2, loose=0.4,
            loose_breakaway=0.45,
        )  # fmt: skip
        motion = np.array([0.0, rng.normal(), rng.normal(), 0.1 * rng.uniform(-1, 1)])
        command = float(rng.normal(scale=2.0))
        whole = moved(record, motion, command, 0.4)
        parts = moved(record, motion, command, 0.4, parts=37)
        np.testing.assert_allclose(parts, whole, rtol=1e-7, atol=1e-10)


def test_figures_of_known_responses() -> None:
    """A lag settles after ln 20 time constants. An oscillation v'' + 0.6 v' + 1.09 v overshoots by
    exp(-0.3 pi), its extremes fall by this factor, and five swings exceed 1 %."""
    time = np.arange(20_000) * 1e-3
    lag = 1.0 - np.exp(-time)
    ring = 1.0 - np.exp(-0.3 * time) * (np.cos(time) + 0.3 * np.sin(time))
    for response, expected in ((lag, (0.0, 0.0)), (ring, (38.97, 5.0))):
        run = Run(response, np.zeros(time.size), response)
        samples, overshoot, error, turns, *_ = hold_figures(
            run, slice(0, time.size), 0.0, 1.0, 1e-4, -1
        )
        largest, turned = expected
        assert overshoot == pytest.approx(largest, abs=0.02)
        assert turns == turned
        assert error == pytest.approx(abs(1.0 - response[-2000:].mean()), abs=1e-12)
        outside = np.flatnonzero(np.abs(response - response[-2000:].mean()) > 0.05)
        assert samples == outside[-1] + 1
        if response is lag:
            assert samples * 1e-3 == pytest.approx(math.log(20.0), abs=2e-3)
    moving = Run(time, np.full(time.size, 2.0), time)
    figures = hold_figures(moving, slice(0, time.size), 0.0, 10.0, 1e-4, 15_000)
    assert figures[4:] == pytest.approx([4.999, 2.0, 2.0])


def test_the_margin_of_a_loop_with_a_closed_form() -> None:
    """A pure gain on a delayed integrator: |1 + L| at its least by a dense search."""
    actuator = dataclasses.replace(draw("test", 0), lag=0.0, delay=1, period=1.0)
    plant = Plant(inertia=1.0, viscous=0.0, coulomb=1.0, constant=1.0, phase=0.0)
    sampled = sampled_axis(actuator, plant)
    z = np.exp(1j * np.geomspace(1e-4, math.pi, 200_000))
    speed = 0.3 * 0.5 * (z + 1.0) / (z * (z - 1.0)) / z  # gain 0.3 on (x[k] - x[k-1])
    one = np.zeros((1, 0))
    controller = type(sampled)(np.zeros((0, 0)), np.zeros((0, 2)), one, np.array([[0.0, 0.3]]))
    assert loop_margin(sampled, controller) == pytest.approx(np.abs(1.0 + speed).min(), rel=1e-6)
    unstable = controller._replace(d=np.array([[0.0, 3.0]]))
    assert loop_margin(sampled, unstable) == 0.0


@pytest.fixture(scope="module")
def clutch(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The clutch, a controller with its exported C, and a simulated log of two steps."""
    folder = tmp_path_factory.mktemp("clutch")
    controller = truthful(clutch_controller(BRAKE_LAW))
    save(clutch_model(), folder / "model.yaml")
    save(controller, folder / "controller.yaml")
    scenario = yaml.safe_load((ROOT / "configs/clutch/scenarios/vertices.yaml").read_text())
    scenario |= {"steps": scenario["steps"][:2], "drive_noise": 0.0}
    (folder / "steps.yaml").write_text(yaml.safe_dump(scenario))
    run_checked("export", folder / "controller.yaml", "--lang", "c", "-o", folder / "c")
    run_checked(
        "simulate", folder / "model.yaml", "--controller", folder / "controller.yaml",
        "--scenario", folder / "steps.yaml", "-o", folder / "run.mcap",
    )  # fmt: skip
    return folder, yaml.safe_load((folder / "controller.yaml").read_text())


def clutch_actuator() -> Actuator:
    bench = clutch_model().bench
    assert bench.mechanics.backlash is not None
    assert bench.mechanics.backlash_coulomb is not None
    return dataclasses.replace(
        draw("test", 0),
        period=bench.sample_period_s,
        delay=bench.delay_samples,
        lag=bench.actuator.loop_time_constant_s,
        encoder_step=bench.encoder.resolution,
        limit=bench.actuator.limit.value,
        coulomb=Interval(0.099, 0.018, 0.18),
        breakaway_ratio=1.1,
        backlash=bench.mechanics.backlash.value,
        backlash_coulomb=bench.mechanics.backlash_coulomb.value,
        amplitude=40.0,  # starts at 5 rad
    )


def test_the_judge_and_simulate_agree_on_the_clutch(clutch: tuple[Path, dict[str, Any]]) -> None:
    """Every reading of the encoder and every command is the same at the nominal plant and at the 16
    vertices, although the engines share no code."""
    folder, _ = clutch
    controller, actuator = load_exported(folder / "c"), clutch_actuator()
    streams = read_log(folder / "run.mcap").streams
    corners = corner_points(ranges(clutch_model()))
    nominal = Plant(1.32e-5, 3.81e-4, 0.099, 13.4e-3, 0.0)
    plants = {"/axis": nominal} | {
        f"/axis/{corner.name}": Plant(
            corner.inertia, corner.viscous, corner.coulomb, corner.constant, 0.0
        )
        for corner in corners
    }
    assert len(streams) == 17
    for stream in streams:
        plant, signals = plants[stream.topic], stream.signals
        reference = np.ascontiguousarray(signals["reference"])
        run = play(axis_record(actuator, plant), reference, controller, plant)
        np.testing.assert_allclose(run.positions, signals["position_true"], rtol=0, atol=1e-9)
        np.testing.assert_array_equal(run.seen, signals["position"])
        np.testing.assert_array_equal(run.commands, signals["command"])


def test_the_judge_and_verify_agree_on_margins(clutch: tuple[Path, dict[str, Any]]) -> None:
    _, document = clutch
    for vertex in document["verified"]["vertices"]:
        plant = Plant(**{name: vertex[name] for name in VARIED}, phase=0.0)
        assert margin(clutch_actuator(), plant, document) == pytest.approx(
            vertex["modulus_margin"], rel=1e-5
        )


def test_the_search_ends_with_a_controller_that_the_judge_accepts() -> None:
    actuator = draw("test", 0)
    plants = draw_plants(actuator, "test")
    found = search(actuator, plants)
    assert found.solved
    assert found.verdict is not None
    assert found.verdict.plants == (True,) * len(plants)
    parameters = np.array(found.parameters)
    assert found.verdict.worst["modulus_margin"] == pytest.approx(
        min(cascade_margin(actuator, plant, parameters) for plant in plants)
    )
    assert not search(
        dataclasses.replace(actuator, response=0.2 * actuator.response), plants, 20
    ).solved
