"""`simulate --as-bench`: a test played with encoder, noise, limits and delay of a usual bench."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from frictool.documents.writing import to_yaml
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.simulate.default_servo import default_servo
from studies.command_line import run, run_checked
from studies.promises.rigs import benches, truth
from tests.support.command_line import refused

pytestmark = pytest.mark.usefixtures("no_rehearsals")

RIGS = {bench.name: bench for bench in benches()}


def played(folder: Path, name: str, test: str, *options: object) -> Log:
    bench = RIGS[name]
    model = folder / "truth.yaml"
    model.write_text(to_yaml(truth(bench, 1)))
    log = folder / "log.mcap"
    run_checked("simulate", "--as-bench", model, folder / test, "-o", log, *options)
    return read_log(log, bench)


def bench_file(folder: Path, name: str) -> Path:
    path = folder / "bench.yaml"
    path.write_text(to_yaml(RIGS[name]))
    return path


@pytest.mark.parametrize("name", ["joint-2000", "belt", "stage", "clutch"])
def test_the_axis_follows_and_is_measured_in_counts(tmp_path: Path, name: str) -> None:
    bench = RIGS[name]
    options = ("--bench", bench_file(tmp_path, name), "--for", "coulomb=5%")
    run_checked("excite", *options, "-o", tmp_path / "test.mcap")
    log = played(tmp_path, name, "test.mcap")
    position, reference = log.main.signals["position"], log.main.signals["reference"]
    counts = position / bench.encoder.resolution
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-5)
    slack = max(bench.mechanics.backlash.interval) if bench.mechanics.backlash else 0.0
    assert np.sqrt(np.mean((position - reference) ** 2)) < 0.15 * np.ptp(reference) + slack
    current = log.main.signals["current"]
    assert np.abs(current).max() <= 1.02 * bench.actuator.limit.value
    noise = np.diff(current, 4).std() / np.sqrt(70.0)
    assert noise > 0.0015 * bench.actuator.limit.value


def test_csv_of_a_reference_is_played_like_the_mcap(tmp_path: Path) -> None:
    options = ("--bench", bench_file(tmp_path, "belt"), "--for", "coulomb=5%", "-o")
    for name in ("test.mcap", "test.csv"):
        run_checked("excite", *options, tmp_path / name)
    one = played(tmp_path, "belt", "test.mcap", "--seed", "3")
    other = played(tmp_path, "belt", "test.csv", "--seed", "3")
    np.testing.assert_allclose(
        one.main.signals["position"], other.main.signals["position"], atol=2e-5
    )


def test_ramps_are_played_by_their_rules(tmp_path: Path) -> None:
    bench = bench_file(tmp_path, "joint-2000")
    run_checked("excite", "--bench", bench, "--for", "breakaway=5%", "-o", tmp_path / "ramps.mcap")
    log = played(tmp_path, "joint-2000", "ramps.mcap")
    assert np.ptp(log.main.signals["position"]) > 0.0
    run_checked("excite", "--bench", bench, "--for", "breakaway=5%", "-o", tmp_path / "ramps.csv")
    result = run(
        *("simulate", "--as-bench", tmp_path / "truth.yaml", tmp_path / "ramps.csv"),
        *("-o", tmp_path / "no.mcap"),
    )
    refused(result, 3, "ramps.csv", "write a test with ramps as MCAP")


def test_wrong_command_lines(tmp_path: Path) -> None:
    model = tmp_path / "truth.yaml"
    model.write_text(to_yaml(truth(RIGS["belt"], 1)))
    assert run("simulate", model, model, "-o", tmp_path / "a.mcap").code == 2
    assert run("simulate", "--as-bench", model, "-o", tmp_path / "a.mcap").code == 2
    bad = tmp_path / "bad.csv"
    bad.write_text("time [s],reference [m]\n0,zero\n")
    refused(run("simulate", "--as-bench", model, bad, "-o", tmp_path / "a.mcap"), 3, "bad.csv")


def test_gains_follow_from_delay_and_encoder() -> None:
    fine, coarse = default_servo(RIGS["stage"]), default_servo(RIGS["servo-24"])
    bench = RIGS["stage"]
    assert fine.derivative / bench.mechanics.inertia.value == pytest.approx(0.5 / 2e-3)
    servo = RIGS["servo-24"]
    count = coarse.derivative * servo.encoder.resolution / servo.sample_period_s
    assert count == pytest.approx(0.25 * coarse.limit)
