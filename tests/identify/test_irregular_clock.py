"""Records of clocks that jitter or have gaps, and logs of different sample periods in one fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace as replace_struct

from frictool.documents.quantity import Quantity
from frictool.errors import LogError
from frictool.identify.estimators.auto import auto
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.estimators.stribeck_curve import find_runs, stribeck_curve
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import LONGEST_BRIDGE, MotionRecord, make_record
from studies.rigs.curve_logs import mass_sines
from studies.rigs.identification_rigs import MASS, clutch, mass_bench

STEP = 0.01
COULOMB = 0.1
VISCOUS = 4e-4
OFFSET = 0.004


def jittering(gap: float = 0.0) -> MotionRecord:
    """A sine sampled at random intervals of 4 to 16 ms, with a lagging effort."""
    generator = np.random.default_rng(5)
    time = np.cumsum(generator.uniform(0.4, 1.6, 3000)) * STEP
    time[1500:] += gap
    return make_record("jitter", time, np.sin(time), np.cos(time), 1e-6, lag=0.001)


def test_a_jittering_record_is_put_on_a_uniform_grid() -> None:
    record = jittering()
    assert np.allclose(np.diff(record.time), record.period)
    longest = 1.6 * STEP  # at a turning point the error is that of a chord at most
    assert np.max(np.abs(record.position - np.sin(record.time))) < longest**2 / 8.0
    assert np.max(np.abs(record.effort - np.cos(record.time))) < 0.5 * STEP**2
    assert record.piece.max() == 0


def test_a_gap_ends_a_piece_and_is_not_filled() -> None:
    record = jittering(gap=2.0 * LONGEST_BRIDGE * STEP)
    assert record.piece.max() == 1
    first = record.time[record.piece == 0]
    second = record.time[record.piece == 1]
    assert second[0] - first[-1] > LONGEST_BRIDGE * STEP


def test_a_held_effort_keeps_its_impulse() -> None:
    generator = np.random.default_rng(6)
    time = np.cumsum(generator.uniform(0.4, 1.6, 500)) * STEP
    effort = generator.standard_normal(500)
    record = make_record("held", time, np.sin(time), effort, 1e-6, lag=0.0)
    whole = np.sum(effort[:-1] * np.diff(time))
    tail = 2.0 * record.period * np.max(np.abs(effort))
    assert np.sum(record.effort) * record.period == pytest.approx(whole, abs=tail)


def test_a_clock_that_stands_still_is_refused() -> None:
    time = np.array([0.0, 0.01, 0.01, 0.02])
    with pytest.raises(LogError, match=r"does not increase after 0.01 s"):
        make_record("still", time, time, time, 1e-6, lag=0.0)


def jittered(record: MotionRecord, seed: int) -> MotionRecord:
    """The record with a quarter of its rows lost."""
    kept = np.sort(
        np.random.default_rng(seed).permutation(record.time.size)[record.time.size // 4 :]
    )
    return make_record(
        record.name,
        record.time[kept],
        record.position[kept],
        record.effort[kept],
        record.resolution,
        record.lag,
    )


def test_records_of_two_periods_with_lost_rows_give_the_true_parameters(tmp_path: Path) -> None:
    logs = mass_sines(3)
    mixed = [
        *logs[:2],
        jittered(logs[2], 7),
        replace(logs[3].part(np.arange(0, logs[3].time.size, 2)), period=2.0 * logs[3].period),
        logs[4],
    ]
    fit = least_squares(mixed, mass_bench(tmp_path), IdentificationSettings())
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.parameters[name].value == pytest.approx(getattr(MASS, name), rel=0.03)


def rippling_runs(signs: tuple[float, ...]) -> list[MotionRecord]:
    """Logs at constant speeds with a ripple of the servo far above a count, one log each."""
    generator = np.random.default_rng(8)
    time = np.arange(2000) * 1e-3
    logs = []
    for speed in np.geomspace(5.0, 100.0, 8):
        for sign in signs:
            position = sign * speed * (time + 1e-3 * np.sin(30.0 * time))
            effort = sign * (COULOMB + VISCOUS * speed) + OFFSET
            noise = 1e-3 * generator.standard_normal(time.size)
            name = f"{sign * speed:.3g}"
            logs.append(make_record(name, time, position, effort + noise, 1e-6, lag=0.003))
    return logs


def test_auto_takes_the_curve_for_logs_at_constant_speeds() -> None:
    fit = auto(rippling_runs((1.0, -1.0)), clutch(), IdentificationSettings())
    assert fit.method == "stribeck-curve"
    for name, value in (("coulomb", COULOMB), ("viscous", VISCOUS), ("offset", OFFSET)):
        assert fit.parameters[name].low <= value <= fit.parameters[name].high
    assert "inertia" in fit.refused


def test_runs_in_one_direction_use_the_offset_of_the_bench() -> None:
    bench = clutch()
    alone = replace_struct(bench, mechanics=replace_struct(bench.mechanics, offset=None))
    logs = rippling_runs((1.0,))
    with pytest.raises(UnusableLogs, match=r"mechanics\.offset"):
        stribeck_curve(logs, alone, IdentificationSettings())
    known = Quantity(0.004, 0.003, 0.005, "N m")
    declared = replace_struct(bench, mechanics=replace_struct(bench.mechanics, offset=known))
    fit = stribeck_curve(logs, declared, IdentificationSettings())
    coulomb = fit.parameters["coulomb"]
    assert coulomb.low <= COULOMB <= coulomb.high
    assert coulomb.half_width > 0.001
    assert "one direction" in fit.refused["offset"]


def test_the_planned_runs_are_found_at_their_speeds() -> None:
    test = excite("speeds", clutch(), ExcitationSettings(duration=40.0, speeds=8))
    reference = test.columns["reference"]
    speed = test.columns["reference_velocity"]
    assert np.cumsum(speed)[-1] * test.period == pytest.approx(0.0, abs=1e-3)
    record = make_record("plan", test.time, reference, speed, 1e-3, lag=0.0)
    runs = find_runs([record])
    planned = np.array([test.figures[f"speed_{number}"] for number in range(1, 9)])
    nearest = np.argmin(np.abs(runs.speed[:, None] / planned - 1.0), axis=1)
    assert np.allclose(runs.speed, planned[nearest], rtol=1e-3)
    assert set(nearest.tolist()) == set(range(8))
    assert np.sum(runs.sign) == 0.0


def test_a_slow_sine_is_no_run() -> None:
    with pytest.raises(UnusableLogs, match="runs at a constant speed"):
        find_runs([jittering()])


def test_rounded_time_stamps_leave_one_gap_free_piece() -> None:
    """Stamps of a regular clock, cut to whole milliseconds, deviate by up to half a period."""
    time = STEP * np.arange(3000)
    stamps = time.copy()
    stamps[100::100] += 0.45 * STEP
    record = make_record("rounded", stamps, np.sin(time), np.cos(time), 1e-6, lag=0.001)
    assert record.piece.max() == 0
    assert np.abs(record.time - time).max() < 0.01 * STEP


def test_a_missing_sample_still_begins_a_new_piece() -> None:
    time = np.delete(STEP * np.arange(3000), 1500)
    record = make_record("gap", time, np.sin(time), np.cos(time), 1e-6, lag=0.001)
    assert record.piece.max() == 1
