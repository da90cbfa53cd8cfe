"""A position with noise of several counts, an unsigned effort, and an effort that is read late."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.estimators.auto import auto
from frictool.identify.estimators.searched_records import SearchedRecords
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.identification import identify_records
from frictool.identify.measurement_faults import one_sided_effort, refuse_unmeasured
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector
from tests.identify.arm import PERIOD, Arm, play, write_bench

ARM = Arm(inertia=5e-3, viscous=0.03, coulomb=0.12, breakaway=0.12, counts=8192)
SERVO = (8.0, 5.0, 0.6)
SETTINGS = IdentificationSettings()
NOISE = 0.004  # N m, standard deviation of the effort's noise


@cache
def motion() -> tuple[Vector, Vector]:
    """Return position and effort (n,) of three sines, one after the other."""
    time = np.arange(25_000) * PERIOD
    parts = ((0.0, 9.0, 2.0, 0.4), (9.0, 17.0, 1.5, 1.2), (17.0, 25.0, 0.6, 3.0))
    command = np.zeros(time.size)
    for start, end, size, frequency in parts:
        inside = (time >= start) & (time < end)
        rise = np.minimum(1.0, frequency * np.minimum(time - start, end - time))
        command += inside * rise * size * np.sin(2.0 * np.pi * frequency * (time - start))
    position, effort = play(ARM, command, SERVO)
    return position, effort + NOISE * np.random.default_rng(5).standard_normal(effort.size)


def record(position: Vector, effort: Vector, period: float = PERIOD) -> MotionRecord:
    time = np.arange(position.size) * period
    return make_record("log.csv", time, position, effort, ARM.step, lag=0.0)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return load(write_bench(tmp_path, ARM), Bench)


def test_noise_of_several_counts_is_no_reversal(bench: Bench) -> None:
    """Potentiometers have such a noise; it must not cut strokes into pieces."""
    position, effort = motion()
    noise = np.random.default_rng(1).integers(-8, 9, position.size) * ARM.step
    noisy = record(position + noise, effort)
    assert find_strokes(noisy).number.max() <= find_strokes(record(position, effort)).number.max()
    refuse_unmeasured([noisy], bench)  # the noise is no end stop
    result = identify_records([noisy], [], bench, DEFAULT, SETTINGS)
    for name in ("inertia", "viscous", "coulomb"):
        one, truth = result.identified[name], getattr(ARM, name)
        assert one.low <= truth <= one.high
        assert one.value == pytest.approx(truth, rel=0.1)


def test_an_absolute_value_of_the_effort_is_refused_by_name(bench: Bench) -> None:
    position, effort = motion()
    for unsigned in (np.abs(effort), -np.abs(effort)):
        with pytest.raises(UnusableLogs, match=r"log\.csv: the effort has one sign .* absolute"):
            refuse_unmeasured([record(position, unsigned)], bench)
        one_sided = one_sided_effort([record(position, effort), record(position, unsigned)])
        assert one_sided is not None
        assert "multiply the effort by it" in one_sided
    assert one_sided_effort([record(position, effort)]) is None


def test_efforts_with_one_sign_that_are_measured_are_kept(bench: Bench) -> None:
    """A weight keeps the effort positive; a drive that only pushes is a saturated one."""
    position, effort = motion()
    for weight in (1.5, -float(effort.min())):  # the second effort reaches 0 once
        refuse_unmeasured([record(position, effort + weight)], bench)
    with pytest.raises(UnusableLogs, match="saturated"):
        refuse_unmeasured([record(position, np.maximum(effort, 0.0))], bench)


def test_an_effort_that_is_late_by_a_sample_is_a_delay_although_the_encoder_hides_it(
    bench: Bench,
) -> None:
    """The test's phases have different speeds: warming explains a part of what a delay explains."""
    position, effort = motion()
    late = record(position[::2], np.roll(effort[::2], 1), 2.0 * PERIOD)
    search = SearchedRecords.of([late], bench, SETTINGS)
    assert search.noisy(search.samples(()))
    fit = auto([late], bench, SETTINGS)
    assert [one.name for one in fit.explanations if one.state == "used"] == ["delay"]
    assert fit.effects["delay"].value == pytest.approx(2.0 * PERIOD, rel=0.5)
    for name in ("inertia", "viscous", "coulomb"):
        assert fit.parameters[name].value == pytest.approx(getattr(ARM, name), rel=0.02)
    punctual = record(position[::2], effort[::2], 2.0 * PERIOD)
    used = [one.name for one in auto([punctual], bench, SETTINGS).explanations]
    assert "warming" not in used
