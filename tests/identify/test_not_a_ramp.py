"""A creeping axis and an arm in gravity rest between counts too; they are no breakaway ramps, for
`identify` and for `info`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify import method_trials
from frictool.identify.breakaway.onset_detection import find_onsets, is_ramp, why_unusable
from frictool.identify.motion_record import make_record
from frictool.logs.quality.ramps import are_ramps, rests_of
from studies.command_line import CommandResult, run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.command_line import refused

TIME = np.arange(12_000) * PERIOD
SERVO = (60.0, 100.0, 1.0)
MOTIONS = {
    "one slow run": (Arm(), 0.03 * TIME, SERVO),
    "one slow run of a coarser encoder": (Arm(counts=2048), 0.03 * TIME, SERVO),
    "one slower run of a finer encoder": (Arm(counts=16384), 0.01 * TIME, SERVO),
    "a slow run upwards": (Arm(gravity=3.3), 0.03 * TIME, SERVO),
    "a slow run without an integrator": (
        Arm(gravity=3.3, counts=1024),
        0.03 * TIME,
        (60.0, 0.0, 1.0),
    ),
    "slow swings": (Arm(gravity=3.3, counts=1024), 0.5 * np.sin(1.0 * TIME), SERVO),
    "an effort that rises and falls": (
        Arm(gravity=3.3, counts=1024),
        3.0 * np.sin(1.0 * TIME),
        (0.0, 0.0, 0.0),
    ),
}


def ramps(arm: Arm, rounds: int, seconds: float = 0.5) -> np.ndarray:
    """An effort that rises to 1.3 times the breakaway, `rounds` times forward and backward in turn,
    each time from 0."""
    rise = np.arange(round(seconds / PERIOD)) * PERIOD / seconds * 1.3 * arm.breakaway
    pause = np.zeros(round(0.3 / PERIOD))
    return np.concatenate([part for k in range(rounds) for part in (rise * (-1.0) ** k, pause)])


def noisy(effort: np.ndarray, seed: int) -> np.ndarray:
    return effort + 0.005 * np.random.default_rng(seed).standard_normal(effort.size)


@pytest.fixture(autouse=True)
def untried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Survey without a trial of the methods, on which the kind of test does not depend."""
    monkeypatch.setattr(method_trials, "tried_methods", lambda log, bench, reasons: reasons)


def slow_log(tmp_path: Path, name: str) -> tuple[Path, Path]:
    """Return the log of a slow motion, and its bench."""
    arm, command, gains = MOTIONS[name]
    position, effort = play(arm, command, gains)
    return (
        write_log(tmp_path / "slow.csv", position, noisy(effort, 1)),
        write_bench(tmp_path, arm),
    )


@pytest.mark.parametrize("name", list(MOTIONS))
def test_a_slow_motion_is_no_ramp(tmp_path: Path, name: str) -> None:
    assert kind(*slow_log(tmp_path, name)) != "ramp"


@pytest.mark.parametrize(
    "name",
    [
        name
        if name in ("one slow run", "an effort that rises and falls")
        else pytest.param(name, marks=pytest.mark.accept)
        for name in MOTIONS
    ],
)
def test_a_slow_motion_gives_no_breakaway(tmp_path: Path, name: str) -> None:
    log, bench = slow_log(tmp_path, name)
    result = run("identify", log, "--bench", bench, "--method", "least-squares", "--json")
    assert result.code in (0, 1, 4), result.stderr
    told = json.loads(result.stdout)
    assert told["logs"] == [{"name": "slow.csv", "kind": "sliding"}]
    assert "breakaway" not in told["parameters"]


def kind(log: Path, bench: Path) -> str:
    """The kind of test that `info` tells."""
    shown = run("info", log, "--bench", bench, "--json")
    assert shown.code in (0, 1), shown.stderr
    return str(json.loads(shown.stdout)["test"]["kind"])


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_ramps_are_ramps_with_an_offset_too(tmp_path: Path, offset: float) -> None:
    """An offset moves the level of both directions, and not what the effort rises by."""
    arm = Arm()
    position, effort = play(arm, ramps(arm, 24))
    log, bench = (
        write_log(tmp_path / "ramps.csv", position, noisy(effort, 2) + offset * arm.breakaway),
        write_bench(tmp_path, arm),
    )
    told = identified(run("identify", log, "--bench", bench, "--json"))
    assert told["logs"] == [{"name": "ramps.csv", "kind": "ramp"}]
    found = told["parameters"]["breakaway"]
    assert found["low"] <= arm.breakaway <= found["high"]
    assert kind(log, bench) == "ramp"


def identified(result: CommandResult) -> dict[str, dict[str, dict[str, float]]]:
    assert result.code == 0, result.stderr
    return dict(json.loads(result.stdout))


def test_a_breakaway_that_a_load_decides_is_refused(tmp_path: Path) -> None:
    """An arm that is raised and lowered in steps starts by its weight too: what the effort is then
    is not friction."""
    arm = Arm(gravity=3.3, counts=1024)
    position, effort = play(
        arm,
        0.4 * (1.0 - np.abs((np.arange(30_000) * PERIOD / 10.0) % 2.0 - 1.0)),
        (60.0, 100.0, 0.4),
    )
    log, bench = (
        write_log(tmp_path / "lowered.csv", position, noisy(effort, 3)),
        write_bench(tmp_path, arm),
    )
    result = run("identify", "--ramp", log, "--bench", bench)
    assert result.code == 1, result.stderr
    assert "remove the load (gravity, a spring)" in result.stderr


def test_a_log_without_a_rest_that_is_named_as_ramps_is_refused(tmp_path: Path) -> None:
    arm = Arm()
    position, effort = play(arm, 3.0 * np.sin(6.0 * TIME[:4000]))
    never = position + 2.0 * arm.step * np.arange(position.size)  # a count at each sample
    log, bench = write_log(tmp_path / "moving.csv", never, effort), write_bench(tmp_path, arm)
    refused(run("identify", "--ramp", log, "--bench", bench), 1, "0 breakaways")


def test_a_log_with_ramps_among_creep_states_why_it_is_no_log_of_ramps(tmp_path: Path) -> None:
    """Teeth from a high level, as of creep, rest as long before motions as the ramps."""
    arm = Arm()
    tooth = np.linspace(0.0, 1.0, 100)
    effort = np.concatenate([*[tooth] * 12, *[0.8 + 0.2 * tooth] * 12]) * arm.breakaway
    position = np.repeat(np.arange(24.0), 100) * arm.step
    log = make_record("teeth", np.arange(2400) * PERIOD, position, effort, arm.step, 0.0)
    bench = load(write_bench(tmp_path, arm), Bench)
    assert not is_ramp(log, bench)
    reason = why_unusable(log, bench)
    assert reason is not None
    assert "teeth is read as sliding: its 12 ramps take 52 % of the time at rest before" in reason
    assert why_unusable(log.part(slice(1200, None)), bench) is None


def test_the_rise_decides_and_not_the_line() -> None:
    """A sawtooth of the effort on top of a level, one tooth a count: ramps if and only if it starts
    low."""
    tooth = np.linspace(0.0, 1.0, 100)
    position = np.repeat(np.arange(20.0), 100)
    rests = rests_of(np.diff(position) != 0.0)
    for bottom, ramp in ((0.0, True), (0.3, True), (0.7, False), (0.95, False)):
        assert are_ramps(rests, position, np.tile(bottom + (1.0 - bottom) * tooth, 20)) == ramp, (
            bottom
        )
    assert not are_ramps(rests, -position, np.tile(tooth, 20))  # the drive opposes the motion
    assert not are_ramps(rests[:4], position[:500], np.tile(tooth, 5))  # too few


def test_a_rest_between_counts_while_the_axis_starts_is_no_onset(tmp_path: Path) -> None:
    """A heavy axis on a coarse encoder starts so slowly that the encoder rests again: the effort is
    then above the breakaway."""
    arm = Arm(counts=2000, inertia=2.0)
    position, effort = play(arm, ramps(arm, 12, seconds=4.0))
    rests = rests_of(np.diff(position) != 0.0)
    assert min(end - start for start, end in rests) < 100
    log = make_record("heavy", np.arange(position.size) * PERIOD, position, effort, arm.step, 0.0)
    found = find_onsets(log, load(write_bench(tmp_path, arm), Bench))
    assert len(found) >= 10
    assert min(onset.rested for onset in found) > 0.5
