"""Servo models on the records of a pendulum bench, and BAM's published M6 in the same score."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.from_logs import identify
from frictool.logs.log_reader import read_log
from studies.field.bam_m6 import parameters, simulated
from studies.field.manifest import HERE
from studies.field.servo_rotation import (
    BENCH,
    FOLDER,
    PUBLISHED,
    STATED_SUPPLY,
    TRAJECTORIES,
    fitted_errors,
    published_errors,
    record_files,
    rotation_lines,
    score,
)

DATA = Path(os.environ.get("FRICTOOL_DATA", HERE.parents[2] / "shared" / "data")) / "field"
needs_data = pytest.mark.skipif(
    not (DATA / FOLDER).is_dir(), reason=f"no {FOLDER} below FRICTOOL_DATA (docs/field.md)"
)


def test_a_folder_without_records_has_no_lines(tmp_path: Path) -> None:
    assert rotation_lines(tmp_path) == []


def test_the_simulated_m6_swings_like_a_pendulum() -> None:
    """Without friction and torque, the period of small swings is 2 pi sqrt(inertia / torque)."""
    p = np.zeros(15)
    p[0], p[1], p[12], p[13] = 1.0, 1.0, 0.1, 1.0
    inertia, torque, period = 0.02, 1.3, 0.001
    still = np.zeros((2, 4000))
    x = simulated(p, (inertia, torque), np.zeros(4000), still, 0.05, period)
    falling = np.flatnonzero((x[:-1] > 0.0) & (x[1:] <= 0.0)) * period
    expected = 2.0 * np.pi * np.sqrt(inertia / torque)
    assert np.mean(np.diff(falling)) == pytest.approx(expected, rel=2e-3)


@needs_data
def test_records_are_interpolated_and_their_supply_is_measured() -> None:
    """The manifest's traps: every log lies between the counts; the voltage is 12 V, not `vin`."""
    bench = load(BENCH, Bench)
    logs = [read_log(record_files(DATA, name)[0], bench) for name in ("brutal", "sin_sin")]
    assert all(11.0 < float(np.median(log.main.signals["supply"])) < 13.0 for log in logs)
    result = identify(logs, bench).result
    assert any(text.startswith("2 of 2 logs have positions between") for text in result.warnings)
    assert parameters(DATA / FOLDER / PUBLISHED).size == 15


@needs_data
@pytest.mark.accept
def test_unseen_trajectories_are_predicted_at_least_as_well_as_by_the_published_model() -> None:
    bench = load(BENCH, Bench)
    logs = {
        name: [read_log(path, bench) for path in record_files(DATA, name)] for name in TRAJECTORIES
    }
    fitted = fitted_errors(logs, bench)
    assert not isinstance(fitted, str)
    assert score(fitted) <= score(published_errors(logs, DATA, STATED_SUPPLY))
    assert score(fitted) <= score(published_errors(logs, DATA, None))
