"""Friction that falls over the speed: the breakaway's interval holds every Stribeck velocity that
the encoder does not refute."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictool.identify.breakaway.onset import STEPS, looked_up, travel, write_travel_tables
from frictool.identify.breakaway.stribeck_velocity import Misfit, StribeckFall, allowed_fall
from frictool.plant.axis import AxisParameters
from frictool.typing import Vector
from studies.command_line import run
from tests.identify.arm import BENCH, PERIOD, write_log
from tests.support.stribeck_rigs import FALLS, Ramps, found_breakaway, play

COUNTS = 8192
RIG = AxisParameters(
    inertia=5e-3, viscous=0.02, coulomb=0.45, breakaway=0.55, encoder_step=2.0 * math.pi / COUNTS
)
RAMPS = Ramps(rate=0.5, counts=6, noise=1e-3)
VELOCITY = 0.3  # rad/s


def bench_of(folder: Path) -> Path:
    ranges = {
        f"{name}_{end}": value
        for name in ("inertia", "coulomb")
        for end, value in _ends(getattr(RIG, name)).items()
    }
    values = {
        "inertia": RIG.inertia,
        "viscous": RIG.viscous,
        "coulomb": RIG.coulomb,
        "viscous_high": 2.0 * RIG.viscous,
    }
    target = folder / "bench.yaml"
    target.write_text(BENCH.format(counts=COUNTS, load="", **values, **ranges))
    return target


def _ends(value: float) -> dict[str, float]:
    return {"low": 0.99 * value, "high": 1.01 * value}


def ramps_of(folder: Path, velocity: float) -> Path:
    axis = RIG._replace(laws=RIG.laws._replace(stribeck_velocity=velocity))
    return write_log(folder / "ramps.csv", *play(axis, RAMPS, 40_000, 1))


def constant_speeds(folder: Path) -> Path:
    """Write a log of speeds to and fro over which the friction falls."""
    speed = np.concatenate(
        [
            np.full(1000, side * value)
            for value in np.geomspace(0.03, 3.0, 9)
            for side in (1.0, -1.0)
        ]
    )
    size = np.abs(speed)
    friction = (
        RIG.coulomb
        + (RIG.breakaway - RIG.coulomb) * np.exp(-((size / VELOCITY) ** 2))
        + RIG.viscous * size
    )
    position = np.floor(np.cumsum(speed) * PERIOD / RIG.encoder_step) * RIG.encoder_step
    noise = RAMPS.noise * np.random.default_rng(2).standard_normal(speed.size)
    return write_log(folder / "speeds.csv", position, np.sign(speed) * friction + noise)


def identify(*arguments: str | Path) -> dict[str, Any]:
    result = run("identify", *arguments, "--json")
    assert result.code == 0, result.stderr
    return dict(json.loads(result.stdout))


@pytest.mark.parametrize(
    "velocity",
    [0.0, VELOCITY, *(pytest.param(one, marks=pytest.mark.accept) for one in (0.1, 2.0))],
)
def test_identify_holds_the_breakaway_of_an_ordinary_stribeck_curve(
    tmp_path: Path, velocity: float
) -> None:
    told = identify(ramps_of(tmp_path, velocity), "--bench", bench_of(tmp_path))
    found, fall = told["parameters"]["breakaway"], told["ramp"]["fall"]
    assert found["low"] <= RIG.breakaway <= found["high"]
    assert found["high"] - found["low"] < 0.5 * (RIG.breakaway - RIG.coulomb)
    assert fall["from"] == "onsets"
    assert fall["low"] <= velocity <= (math.inf if fall["high"] is None else fall["high"])


def test_constant_speeds_narrow_the_interval(tmp_path: Path) -> None:
    log, bench = ramps_of(tmp_path, VELOCITY), bench_of(tmp_path)
    alone = identify(log, "--bench", bench)["parameters"]["breakaway"]
    told = identify(log, constant_speeds(tmp_path), "--bench", bench, "--method", "stribeck-curve")
    both, fall = told["parameters"]["breakaway"], told["ramp"]["fall"]
    assert fall["from"] == "fit"
    assert fall["low"] <= VELOCITY <= fall["high"]
    assert both["low"] <= RIG.breakaway <= both["high"]
    assert both["high"] - both["low"] < 0.5 * (alone["high"] - alone["low"])


def test_the_text_says_what_the_interval_holds_and_what_narrows_it(tmp_path: Path) -> None:
    result = run("identify", ramps_of(tmp_path, 0.0), "--bench", bench_of(tmp_path))
    assert "the interval of the breakaway is valid for Stribeck velocities up to" in result.stdout
    assert "a finer encoder, a slower ramp" in result.stdout


@pytest.mark.parametrize("fall", FALLS)
@pytest.mark.parametrize(
    ("seed", "exponent"),
    [(2, 2.0), *(pytest.param(1, exponent, marks=pytest.mark.accept) for exponent in (1.0, 2.0))],
)
def test_random_rigs(tmp_path: Path, seed: int, exponent: float, fall: str) -> None:
    """The first rigs of `tests/accept/check_breakaway.py`, which counts how often the interval
    holds."""
    axis, found = found_breakaway(seed, fall, tmp_path, exponent=exponent)
    assert found.interval.low <= axis.breakaway <= found.interval.high
    assert (
        found.interval.high - found.interval.low
        < axis.breakaway - axis.coulomb + 0.02 * axis.breakaway
    )


def table_of(
    duration: float, excess: float, rate: float, axis: Vector, velocity: float, exponent: float
) -> Vector:
    """Return the table of one onset, the last of two in one call, as the two tables of a search."""
    durations, falls, rates = np.array([[1.0, duration], [0.5, excess], [2.0, rate]])
    axes = np.array([2.0 * axis, axis])
    tables = np.empty((len(durations), STEPS, 6))
    write_travel_tables(durations, falls, rates, axes, velocity, exponent, tables)
    table = tables[1]
    return np.array([table, table])


@pytest.mark.parametrize("velocity", [1e-12, math.inf])
def test_the_table_is_the_closed_form_where_friction_falls_at_once_or_never(
    velocity: float,
) -> None:
    axis, rate, excess, duration = np.array([5e-3, 0.02, 0.45]), 0.5, 0.1, 0.05
    table = table_of(duration, excess, rate, axis, velocity, 2.0)
    first = duration / STEPS**2
    for time in (0.3 * first, 0.05 * duration, 0.997 * duration):
        exact, later = (
            travel(t, excess if velocity < 1.0 else 0.0, rate, axis[0], axis[1])
            for t in (time, time + first)
        )
        # a fall within the first step is late by a part of it
        assert looked_up(time, duration, table, 0.0) == pytest.approx(
            exact, rel=1e-7, abs=later - exact if velocity < 1.0 else 1e-12
        )
    assert looked_up(-1.0, duration, table, 0.0) == 0.0


@pytest.mark.parametrize("exponent", [2.0, 1.0, 0.5])
@pytest.mark.parametrize("velocity", [0.02, 0.3])
def test_the_table_is_the_solution_of_the_equation_of_motion(
    velocity: float, exponent: float
) -> None:
    """Units in which inertia and rate are 1; the axis moves 2 to 3 lengths."""
    inertia, viscous, rate, excess, duration = 1.0, 0.1, 1.0, 2.0, 1.5
    table = table_of(duration, excess, rate, np.array([inertia, viscous, 0.0]), velocity, exponent)

    def motion(t: float, state: Vector) -> list[float]:
        fallen = -math.expm1(-((max(state[1], 0.0) / velocity) ** exponent))
        return [state[1], (rate * t + excess * fallen - viscous * state[1]) / inertia]

    times = np.linspace(0.05, 1.0, 7) * duration
    solution = solve_ivp(
        motion, (0.0, duration), [0.0, 0.0], method="LSODA", t_eval=times, rtol=1e-11, atol=1e-14
    )
    positions = [looked_up(t, duration, table, 0.0) for t in times]
    assert positions == pytest.approx(solution.y[0], abs=2e-3)


def test_the_allowed_velocities_reach_to_the_next_that_is_refused() -> None:
    def around_one(fall: StribeckFall, most: float) -> float:
        """Misfit with the least value at 1 rad/s and the exponent 2."""
        return 10.0 * math.log(max(fall.velocity, 1e-3)) ** 2 + 100.0 * (fall.exponent != 2.0)

    steep = allowed_fall(around_one, [], 1.0, 0.95)
    assert 0.0 < steep.low < 1.0 < steep.high < math.inf
    assert steep.low < steep.velocity < steep.high
    assert {end.exponent for end in steep.ends} == {2.0}
    flat = allowed_fall(lambda fall, most: 2.0, [], 1.0, 0.95)
    assert (flat.velocity, flat.low, flat.high) == (0.0, 0.0, math.inf)
    immediate_only = [lambda fall, most: 100.0 * (fall.velocity > 0.0)]
    uncertain = allowed_fall(around_one, immediate_only, 1.0, 0.95)
    assert uncertain.low == 0.0
    assert uncertain.velocity > 0.0


@pytest.mark.parametrize("seed", range(20))
def test_misfits_that_end_at_the_limit_change_no_range(seed: int) -> None:
    draw = np.random.default_rng(seed)
    levels = {end: draw.uniform(0.0, 30.0, 200) for end in range(3)}

    def misfit(end: int, ends_early: bool) -> Misfit:
        def level(fall: StribeckFall, most: float) -> float:
            place = int(1e3 * math.log(1.0 + min(fall.velocity, 1e6)) + 10.0 * fall.exponent) % 200
            found = float(levels[end][place])
            return math.inf if ends_early and found > most else found

        return level

    whole, early = (
        allowed_fall(misfit(0, ends), [misfit(1, ends), misfit(2, ends)], 1.0, 0.95)
        for ends in (False, True)
    )
    assert early == whole
