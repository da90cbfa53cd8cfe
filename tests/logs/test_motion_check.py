"""The scales of velocity and position, on random motions with rests of random machines."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import scipy

from frictool.documents.bench import Column, Encoder
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.log import Stream
from frictool.logs.quality.motion_check import CLEAR, motion_doubts, velocity_ratio
from frictool.logs.quality.time_base import encoder_step
from frictool.typing import Vector
from tests.support.example_logs import bench, mapped

COUNTS = 8192
COUNT = 2.0 * math.pi / COUNTS
PERIOD = 0.001
SEEDS = range(12)


def motion(seed: int) -> tuple[Vector, Vector]:
    """Return position [rad] and velocity [rad/s] of random strokes and rests; 12 s."""
    draw = np.random.default_rng(seed)
    speeds = draw.uniform(0.05, 3.0, 20) * draw.choice([-1.0, 0.0, 1.0], 20)
    speeds[[0, -1]] = 0.0
    held = np.repeat(speeds, 600)
    velocity = np.convolve(held, np.hanning(102)[1:-1] / np.hanning(102).sum(), mode="same")
    return draw.uniform(-1.0, 1.0) + PERIOD * np.cumsum(velocity), velocity


def counted(position: Vector, counts: int = COUNTS) -> Vector:
    step = 2.0 * math.pi / counts
    return step * np.floor(position / step)


def doubts(position: Vector, velocity: Vector | None = None, unit: str = "rad") -> tuple[str, ...]:
    """Return the warnings about a log in SI, for a bench with COUNTS a turn."""
    signals = {"position": position} | ({} if velocity is None else {"velocity": velocity})
    stream = Stream(
        "/axis",
        PERIOD * np.arange(position.size),
        signals,
        {"position": "rad", "velocity": "rad/s"},
    )
    encoder = Encoder(counts_per_revolution=COUNTS)
    return motion_doubts(stream, bench({"position": Column("x", unit)}, encoder))


def sensors(seed: int, counts: int) -> dict[str, Vector]:
    """Return position and the velocities of five sensors and filters."""
    draw = np.random.default_rng(seed)
    true, speed = motion(seed)
    position = counted(true, counts)
    difference = np.diff(position, prepend=position[0]) / PERIOD
    lag = math.exp(-1.0 / draw.uniform(1.0, 60.0))
    return {
        "position": position,
        "tachometer": speed + draw.normal(0.0, 0.2, speed.size) + draw.uniform(-0.03, 0.03),
        "difference": difference,
        "filtered": scipy.signal.lfilter([1.0 - lag], [1.0, -lag], difference),
        "late": np.roll(speed, int(draw.integers(1, 60))),
        "coarse": 0.1 * np.rint(speed / 0.1),
    }


@pytest.mark.parametrize("counts", [200, COUNTS, 1 << 20])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_velocity_with_noise_lag_or_steps_is_right(seed: int, counts: int) -> None:
    time = PERIOD * np.arange(motion(seed)[0].size)
    position, *velocities = sensors(seed, counts).values()
    for velocity in velocities:
        low, high = velocity_ratio(time, position, velocity)
        assert low < 1.1
        assert high > 0.9


@pytest.mark.parametrize("ratio", [80.0, 9.549, 2.0, 0.5, 1.0 / 57.3])
@pytest.mark.parametrize("seed", SEEDS)
def test_another_unit_or_a_gear_is_found_with_its_ratio(seed: int, ratio: float) -> None:
    time = PERIOD * np.arange(motion(seed)[0].size)
    position, *velocities = sensors(seed, COUNTS).values()
    for velocity in velocities:
        low, high = velocity_ratio(time, position, ratio * velocity)
        assert math.sqrt(low * high) == pytest.approx(ratio, rel=0.1)
    (text,) = doubts(position, ratio * velocities[0])
    advised = re.search(r"divide columns.velocity.scale by (\S+)", text)
    assert advised is not None
    assert float(advised[1]) == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("jump", [0.5, 300.0])
def test_jumps_of_the_position_do_not_change_the_ratio(jump: float) -> None:
    position, velocity = motion(1)
    for first in (2000, 7000):
        position[first:] += jump * np.ptp(position)
    time = PERIOD * np.arange(position.size)
    low, high = velocity_ratio(time, position, velocity)
    assert low < 1.1
    assert high > 0.9
    assert jump > 1.0 or velocity_ratio(time, position, 80.0 * velocity)[0] > CLEAR


@pytest.mark.parametrize("seed", SEEDS)
def test_an_axis_at_rest_shows_no_ratio(seed: int) -> None:
    draw = np.random.default_rng(seed)
    position = counted(draw.normal(0.0, COUNT, 8000))
    assert doubts(position, draw.normal(0.0, 5.0, 8000)) == ()
    assert doubts(np.zeros(8000), draw.normal(0.0, 5.0, 8000)) == ()
    assert doubts(position, np.zeros(8000)) == ()


def test_units_of_a_file_are_not_compared() -> None:
    position, velocity = motion(0)
    units = {"position": "deg", "velocity": "rpm"}
    signals = {"position": position, "velocity": velocity / 6.0}
    stream = Stream("/axis", PERIOD * np.arange(position.size), signals, units)
    assert motion_doubts(stream, None) == ()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_step_of_rounded_angles_is_that_of_the_encoder(seed: int) -> None:
    """Five decimals of a degree are 1.8 % of a step, so that the distance of two counts varies."""
    degrees = np.round(np.degrees(counted(motion(seed)[0], 655360)), 5)
    assert encoder_step(degrees) == pytest.approx(360.0 / 655360, rel=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gear_between_encoder_and_axis_is_found(seed: int) -> None:
    joint = np.radians(np.round(np.degrees(counted(motion(seed)[0], 80 * COUNTS)), 5))
    (text,) = doubts(joint, unit="deg")
    assert "steps of 9.587e-06 rad, but one count of the encoder is 0.000767 rad" in text
    assert "their ratio is 80 (a gear ratio?)" in text
    assert "encoder.counts_per_revolution" in text


@pytest.mark.parametrize("seed", SEEDS)
def test_counts_that_are_skipped_are_found(seed: int) -> None:
    (text,) = doubts(counted(motion(seed)[0], COUNTS // 4))
    assert "their ratio is 4 (a gear ratio?)" in text


@pytest.mark.parametrize("seed", SEEDS)
def test_a_log_that_rounds_positions_is_found(seed: int) -> None:
    (text,) = doubts(np.radians(np.round(np.degrees(motion(seed)[0]), 0)), unit="deg")
    assert "(a rounded log?)" in text


@pytest.mark.parametrize("seed", SEEDS)
def test_steps_of_interpolation_filters_and_formats_are_no_encoder(seed: int) -> None:
    true = motion(seed)[0]
    exact = counted(true)
    every = np.arange(exact.size)
    filtered = scipy.signal.lfilter([0.1], [1.0, -0.9], exact - exact[0]) + exact[0]
    processed = {
        "exact": exact,
        "between two": np.interp(every[::2] / 2.0, every, exact),
        "between five": np.interp(every / 5.0, every, exact),
        "resampled": np.interp(every[:-1] * 0.937, every, exact),
        "averaged over four": np.convolve(exact, np.full(4, 0.25), mode="valid"),
        "filtered": filtered,
        "single precision": np.float32(filtered).astype(float),
        "six decimals": np.round(filtered, 6),
        "true": true,
    }
    assert {name: text for name, x in processed.items() if (text := doubts(x))} == {}
    assert doubts(np.radians(np.round(np.degrees(filtered), 4)), unit="deg") == ()


def test_whole_counts_a_sample_at_constant_speed_are_no_coarse_encoder() -> None:
    assert doubts(COUNT * 4.0 * np.arange(500.0)) == ()


def test_a_direction_without_counts_is_said() -> None:
    table = MemoryTable({"q": np.arange(4.0)}, {"q": "deg"}, "raw.csv")
    reversed_encoder = Encoder(counts_per_revolution=COUNTS, direction=-1)
    log = mapped(table, bench({"position": Column("q", "deg")}, reversed_encoder))
    assert log.main.signals["position"] == pytest.approx(np.radians(np.arange(4.0)))
    (text,) = (one for one in log.warnings if "direction" in one)
    assert text.startswith("encoder.direction: -1 has no effect on columns.position in deg")
    counts = MemoryTable({"q": np.arange(4.0)}, {}, "raw.csv")
    assert (
        mapped(counts, bench({"position": Column("q", "count")}, reversed_encoder)).warnings == ()
    )
