"""Breakaway ramps with an encoder that flickers between two counts, or a drive train that yields
before the axis breaks away: neither is an onset of motion."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from frictool.identify.breakaway.breakaway import Breakaway, breakaway
from frictool.identify.breakaway.onset_detection import find_onsets
from frictool.identify.breakaway.onset_friction import lower_group, onset_data
from frictool.identify.fit_result import SLIDING, Interval, UnusableLogs
from frictool.identify.identification import identify_records
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.logs.quality.ramps import without_flicker
from frictool.plant.axis import AxisParameters
from frictool.typing import Vector
from studies.rigs.identification_rigs import mass_bench
from tests.identify.arm import PERIOD
from tests.support import compliant_axis
from tests.support.stribeck_rigs import play, random_rig

SAMPLES = 30_000
LONGEST = 190  # characters of a message


def known(axis: AxisParameters) -> dict[str, Interval]:
    return {name: Interval(*[getattr(axis, name)] * 3) for name in SLIDING}


def log_of(axis: AxisParameters, position: Vector, effort: Vector) -> MotionRecord:
    time = PERIOD * np.arange(position.size, dtype=np.float64)
    return make_record("ramps", time, position, effort, axis.encoder_step, 0.0)


def compliant(
    seed: int, yields: float, sensor: float, folder: Path, fall: str = "none"
) -> tuple[AxisParameters, Breakaway]:
    """Return an axis and the breakaway from its ramps.

    The arguments are those of `play` and `random_rig`.
    """
    axis, ramps = random_rig(seed, fall)
    ramps = ramps._replace(counts=max(ramps.counts, 6))
    log = log_of(axis, *compliant_axis.play(axis, ramps, SAMPLES, seed, yields, sensor))
    with np.errstate(all="raise"):
        return axis, breakaway([log], mass_bench(folder), known(axis), 0.95)


FEW = [
    *range(3),
    *(pytest.param(seed, marks=pytest.mark.accept) for seed in range(3, 12)),
]


@pytest.mark.parametrize("seed", FEW)
def test_a_count_by_which_the_drive_train_yields_is_no_onset(tmp_path: Path, seed: int) -> None:
    draw = np.random.default_rng([seed, 5])
    yields = math.exp(draw.uniform(math.log(0.2), math.log(3.0)))
    axis, found = compliant(seed, yields, 0.0, tmp_path)
    assert found.interval.low <= axis.breakaway <= found.interval.high
    assert found.interval.value == pytest.approx(axis.breakaway, rel=0.05)


@pytest.mark.parametrize("seed", FEW)
def test_noise_of_the_effort_hides_no_yielding(tmp_path: Path, seed: int) -> None:
    """A measured current has noise; the onsets are those of the effort without noise."""
    axis, ramps = random_rig(seed, "none")
    ramps = ramps._replace(counts=max(ramps.counts, 12))
    clean = log_of(axis, *compliant_axis.play(axis, ramps, SAMPLES, seed, 5.0, 0.0))
    noise = np.random.default_rng(seed).normal(0.0, 0.06 * axis.breakaway, SAMPLES)
    noisy = replace(clean, effort=clean.effort + noise)
    bench = mass_bench(tmp_path)
    expected, found = (len(find_onsets(log, bench, known(axis))) for log in (clean, noisy))
    assert 5 <= 0.75 * expected <= found <= expected
    level = breakaway([noisy], bench, known(axis), 0.95).interval
    assert level.low <= axis.breakaway <= level.high
    assert level.value == pytest.approx(axis.breakaway, rel=0.05)


@pytest.mark.parametrize("seeds", [2, pytest.param(6, marks=pytest.mark.accept)])
@pytest.mark.parametrize("fall", ["fast", "mid", "slow"])
def test_friction_may_fall_slowly_behind_a_drive_train_that_yields(
    tmp_path: Path, fall: str, seeds: int
) -> None:
    for seed in range(seeds):
        yields = 10.0 ** np.random.default_rng([seed, 7]).uniform(-0.7, 0.5)
        axis, found = compliant(seed, yields, 0.0, tmp_path, fall)
        assert found.interval.low <= axis.breakaway <= found.interval.high


@pytest.mark.parametrize("seed", FEW)
def test_flicker_of_a_count_is_no_onset(tmp_path: Path, seed: int) -> None:
    sensor = math.exp(np.random.default_rng([seed, 6]).uniform(math.log(0.02), math.log(0.15)))
    axis, found = compliant(seed, 1e-3, sensor, tmp_path)
    assert found.interval.low <= axis.breakaway <= found.interval.high
    assert found.interval.value == pytest.approx(axis.breakaway, rel=0.02)


@pytest.mark.parametrize("rigs", [6, pytest.param(20, marks=pytest.mark.accept)])
def test_a_yielding_count_just_before_the_onset_widens_the_interval_upwards(
    tmp_path: Path, rigs: int
) -> None:
    """Such a count looks like friction that falls slowly, from an earlier onset."""
    found = [compliant(seed, 2.0, 0.0, tmp_path) for seed in range(20, 20 + rigs)]
    slow = [(axis, one) for axis, one in found if one.fall.velocity > 0.0]
    assert slow
    for axis, one in slow:
        assert one.interval.low <= axis.breakaway <= one.interval.high


@pytest.mark.parametrize("shift", [-1.5, 0.7, 3.0])
def test_onsets_do_not_depend_on_the_part_of_the_effort_that_is_called_load(
    tmp_path: Path, shift: float
) -> None:
    """A fit may split a constant effort between offset and load in any way."""
    bench = mass_bench(tmp_path)
    for seed in (0, 4):
        axis, ramps = random_rig(seed, "none")
        log = log_of(axis, *compliant_axis.play(axis, ramps, SAMPLES, seed, 2.0, 0.02))
        plain = find_onsets(log, bench, known(axis))
        constant = np.full(SAMPLES, shift * axis.breakaway)
        split = find_onsets(replace(log, load=constant), bench, known(axis))
        moved = find_onsets(replace(log, effort=log.effort + constant), bench, known(axis))
        levels = np.array([one.level for one in plain])
        added = constant[: len(plain)] * [one.direction for one in plain]
        assert [one.level for one in split] == pytest.approx(levels - added)
        assert [one.level for one in moved] == pytest.approx(levels + added)


def test_a_motion_far_below_coulomb_friction_is_no_onset(tmp_path: Path) -> None:
    """Counts of a drive train at low efforts are left out, and counted; a second place is not."""
    axis, ramps = random_rig(0, "none")
    log = log_of(axis, *play(axis, ramps, SAMPLES, 0))
    bench = mass_bench(tmp_path)
    data = onset_data([log], bench, known(axis))
    assert data.rejected == 0
    level, place = np.array([1.0, 9.0, 10.0, 1.2, 11.0, 0.9]), np.arange(6.0)
    assert lower_group(level, place, 1.0).tolist() == [True, False, False, True, False, True]
    assert not np.any(lower_group(level, np.where(level > 2.0, place, place + 50.0), 1.0))
    assert not np.any(lower_group(np.linspace(1.0, 10.0, 12), np.arange(12.0), 1.0))


@pytest.mark.parametrize("seeds", [2, pytest.param(6, marks=pytest.mark.accept)])
@pytest.mark.parametrize("fall", ["none", "slow"])
def test_no_count_of_a_rigid_axis_is_left_out(tmp_path: Path, fall: str, seeds: int) -> None:
    """The first count after the onset is used, also if friction decreases slowly."""
    for seed in range(seeds):
        axis, ramps = random_rig(seed, fall)
        log = log_of(axis, *play(axis, ramps, SAMPLES, seed))
        onsets = find_onsets(log, mass_bench(tmp_path), known(axis))
        assert onsets
        assert not any(onset.yields for onset in onsets)


def test_noise_of_more_than_a_count_is_named(tmp_path: Path) -> None:
    """The breakaways are found up to a noise of 0.3 counts; above, the message tells the cause."""
    axis, found = compliant(3, 1e-3, 0.3, tmp_path)
    assert found.interval.low <= axis.breakaway <= found.interval.high
    with pytest.raises(UnusableLogs, match=r"rests for 30 samples .* filter the position") as error:
        compliant(3, 1e-3, 1.0, tmp_path)
    assert len(str(error.value)) <= LONGEST


def test_the_number_of_breakaways_in_each_direction_is_told(tmp_path: Path) -> None:
    """Three breakaways backward are too few to cancel an offset."""
    axis, ramps = random_rig(1, "none")
    position, effort = play(axis, ramps, SAMPLES, 1)
    bench = mass_bench(tmp_path)
    turn = int(np.argmax(position))
    logs = [log_of(axis, position[:end], effort[:end]) for end in range(turn, SAMPLES, 200)]
    short = next(
        log
        for log in logs
        if sum(one.direction < 0.0 for one in find_onsets(log, bench, known(axis))) == 3
    )
    with pytest.raises(UnusableLogs, match=r"breakaways forward, 3 backward, and no known offset"):
        identify_records([], [short], bench, DEFAULT, IdentificationSettings())


def test_flicker_is_told_from_a_reversal() -> None:
    to_and_fro = np.array([0, 0, 1, 2, 3, 3, 2, 1, 0, 0, 1, 2], dtype=float)
    assert np.array_equal(without_flicker(to_and_fro, 1.0), to_and_fro)
    flicker = np.array([0, 1, 2, 1, 2, 1, 2, 2, 3, 4], dtype=float)
    assert without_flicker(flicker, 1.0).tolist() == [0, 1, 2, 2, 2, 2, 2, 2, 3, 4]
    turned = np.array([0, 1, 2, 1, 2, 1, 1, 0, -1], dtype=float)
    assert without_flicker(turned, 1.0).tolist() == [0, 1, 1, 1, 1, 1, 1, 0, -1]
    large = np.array([0, 2, 0, 2, 0, 2], dtype=float)
    assert np.array_equal(without_flicker(large, 1.0), large)


def behind_a_gap(gap: float) -> tuple[AxisParameters, MotionRecord]:
    """Return an axis, and a log of four ramps in each direction, four times.

    The motor has half of the friction and of the inertia. It moves the load after the gap [counts].
    The gap is closed at the first ramp, and open at the first ramp after each of seven reversals.
    """
    axis, _ = random_rig(0, "none")
    width, span = gap * axis.encoder_step, 12.0 * axis.encoder_step
    seconds = 1.5 * axis.breakaway / axis.coulomb  # duration of a ramp up to the breakaway
    motor = speed = effort = began = 0.0
    load = -0.5 * width
    played, log = 0, []
    while played < 32:
        side = 1.0 if played // 4 % 2 == 0 else -1.0
        touches = side * (motor - load) >= 0.499 * width
        share = 1.0 if touches else 0.5
        effort = side * (abs(effort) + axis.breakaway / seconds * PERIOD)
        if side * (motor - began) >= span:
            effort = 0.0
        if speed == 0.0 and effort == 0.0:
            began = motor
            played += 1
        if speed != 0.0 or abs(effort) > share * axis.breakaway:
            force = effort - side * share * axis.coulomb - axis.viscous * speed
            speed += force / (share * axis.inertia) * PERIOD
            speed = speed if side * speed > 0.0 else 0.0
        motor += speed * PERIOD
        load = min(max(load, motor - 0.5 * width), motor + 0.5 * width)
        log.append((math.floor(motor / axis.encoder_step) * axis.encoder_step, effort))
    position, played_effort = np.array(log).T
    return axis, log_of(axis, position, played_effort)


@pytest.mark.parametrize("gap", [0.0, 8.0])
def test_an_onset_inside_a_backlash_is_no_breakaway_of_the_load(tmp_path: Path, gap: float) -> None:
    axis, log = behind_a_gap(gap)
    found = breakaway([log], mass_bench(tmp_path), known(axis), 0.95)
    assert found.after_reversals == (7 if gap else 0)
    assert found.interval.value == pytest.approx(axis.breakaway, rel=0.05)
