"""The ready scenarios of the clutch, each played to the published non-linear plant; and what may
not be asked."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spread import Spread
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.log import Log
from studies.command_line import CommandResult, run
from studies.rigs.example_controllers import BRAKE_LAW, ROOT, clutch_controller
from studies.rigs.step_scenario import write_rig
from tests.support.command_line import also_called, refused

READY = ROOT / "configs/clutch/scenarios"
NONLINEAR = ROOT / "configs/clutch/nonlinear.yaml"
STEP = 2.0 * np.pi / 56.0


@pytest.fixture(scope="module")
def braking(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("controller") / "controller.yaml"
    path.write_text(to_yaml(clutch_controller(BRAKE_LAW)))
    return path


def play(name: str | Path, controller: Path, folder: Path) -> tuple[CommandResult, Log]:
    """A ready scenario, or one at a path, on the non-linear clutch."""
    path = name if isinstance(name, Path) else READY / f"{name}.yaml"
    result = run(
        "simulate",
        NONLINEAR,
        "--controller",
        controller,
        "--scenario",
        path,
        "-o",
        folder / "run.mcap",
        "--json",
    )
    assert result.code == 0, result.stderr
    return result, read_mcap(folder / "run.mcap")


def test_every_ready_scenario_is_played_here() -> None:
    of_mechanisms = {"mechanism", "rebound"}  # played in test_mechanism_command.py
    assert {path.stem for path in READY.glob("*.yaml")} == {
        "steps",
        "vertices",
        "random",
        "hold",
        "wear",
        "faults",
        "replay",
        "campaign",
        "prove",
    } | of_mechanisms


def test_what_a_campaign_varies_is_left_out(braking: Path, tmp_path: Path) -> None:
    _, log = play("campaign", braking, tmp_path)
    (stream,) = log.streams
    assert (stream.topic, stream.signals["position_true"][0]) == ("/axis", 5.0)
    assert not {"disturbance", "friction_factor", "viscous_factor"} & set(stream.signals)


@pytest.mark.parametrize("name", [pytest.param("steps", marks=pytest.mark.accept), "vertices"])
def test_vertices(name: str, braking: Path, tmp_path: Path) -> None:
    result, log = play(name, braking, tmp_path)
    assert [stream.topic for stream in log.streams] == [
        "/axis",
        *(f"/axis/v{k:02d}" for k in range(1, 17)),
    ]
    assert log.metadata["plants"]["/axis/v01"].startswith(
        "inertia 1.11e-05 kg m^2, viscous 0 N m s/rad, coulomb 0.018 N m"
    )
    assert json.loads(result.stdout)["streams"][1]["plant"] == log.metadata["plants"]["/axis/v01"]
    assert log.main.signals["velocity"][-1] == 0.0
    assert abs(log.main.signals["position"][-1] - 15.0) < 2.0


def test_random(braking: Path, tmp_path: Path) -> None:
    """A tenth of a per cent of its plants, each as in the whole scenario; that is 1001 streams."""
    text = (READY / "random.yaml").read_text()
    assert "plants: 1000\n" in text
    few = tmp_path / "few.yaml"
    few.write_text(
        text.replace("plants: 1000\n", "plants: 6\n").replace("duration_s: 16", "duration_s: 1.1")
    )
    _, log = play(few, braking, tmp_path)
    assert [stream.topic for stream in log.streams] == [
        "/axis",
        *(f"/axis/p{k}" for k in range(1, 7)),
    ]
    assert len({stream.signals["velocity"].tobytes() for stream in log.streams}) == 7
    assert len(set(log.metadata["plants"].values())) == 6


def test_hold_of_ten_minutes(braking: Path, tmp_path: Path) -> None:
    _, log = play("hold", braking, tmp_path)
    assert log.main.time.size == 601_100
    held = log.main.time > 2.0
    assert np.ptp(log.main.signals["position_true"][held]) == 0.0
    assert np.all(log.main.signals["command"][held] == 0.0)


def test_wear_and_warmth(braking: Path, tmp_path: Path) -> None:
    """The same step takes more current when the friction has grown by half and the constant has
    fallen."""
    _, log = play("wear", braking, tmp_path)
    signals, time = log.main.signals, log.main.time
    assert (signals["friction_factor"][0], signals["friction_factor"][-1]) == pytest.approx(
        (1.0, 1.5), abs=1e-5
    )
    assert (signals["constant_factor"][-1], signals["viscous_factor"][-1]) == pytest.approx(
        (0.955, 0.8), abs=1e-5
    )
    assert log.main.units["friction_factor"] == "1"
    charge = []
    for begin in (15.0, 75.0):  # 55 to 5 rad, fresh and worn
        move = (time >= begin) & (time < begin + 0.4)
        charge.append(np.sum(signals["current_true"][move] ** 2) * 1e-3)
    assert charge[1] > 1.1 * charge[0]


def test_faults(braking: Path, tmp_path: Path) -> None:
    result, log = play("faults", braking, tmp_path)
    signals, time = log.main.signals, log.main.time
    assert "runs against its end stop at 0 rad, first at 7.5" in result.stderr

    def spans(begin: float, end: float) -> np.ndarray:
        return np.asarray((time >= begin - 1e-9) & (time < end - 1e-9))

    resting = spans(0.7, 2.0)  # 0.01 N m from 1 s on, less than the friction
    assert np.ptp(signals["position_true"][resting]) == 0.0
    assert np.ptp(signals["position_true"][spans(2.0, 2.2)]) > 0.5  # a knock of 0.4 N m
    assert np.min(signals["disturbance"]) == pytest.approx(-0.39)
    assert np.ptp(signals["position"][spans(7.45, 7.5)]) == 0.0  # stuck, while the axis goes on
    assert np.ptp(signals["position_true"][spans(7.45, 7.5)]) > 5.0
    lost = signals["position_true"] - signals["position"]
    assert np.all(lost[spans(0.0, 6.0)] <= STEP + 1e-9)
    assert np.all(lost[spans(8.0, 30.0)] == pytest.approx(9.5 * STEP, abs=0.5 * STEP + 1e-6))
    shown, true = signals["current"], signals["current_true"]  # noise of 0.05 A
    for begin, gain in ((10.0, 1.0), (12.0, 1.1), (16.0, 1.0)):
        there = spans(begin, begin + 2.0)
        assert np.mean(shown[there] - gain * true[there]) == pytest.approx(0.5, abs=0.01)
    assert signals["current_true"][-1] == pytest.approx(
        -0.5
    )  # the offset is there at rest: i = command - offset, the command 0


def test_replay_of_a_raw_log(braking: Path, tmp_path: Path) -> None:
    _, log = play("replay", braking, tmp_path)
    assert log.metadata["provenance"]["input_4"].startswith("steps.csv sha256:")
    counts = np.loadtxt(ROOT / "sample_logs/steps.csv", delimiter=",", skiprows=1, usecols=1)
    np.testing.assert_allclose(
        log.main.signals["reference"][: counts.size], counts * STEP, rtol=1e-9
    )
    assert log.main.signals["reference"].size == counts.size + 15_000
    assert abs(log.main.signals["position"][-1] - counts[-1] * STEP) < 2.0


def test_replay_of_a_reference(braking: Path, tmp_path: Path) -> None:
    """The reference of a run, played again, gives the same motion to the bit."""
    _, first = play("faults", braking, tmp_path)
    shutil.copy(tmp_path / "run.mcap", tmp_path / "bench.mcap")
    again = tmp_path / "again.yaml"
    again.write_text(
        "format: scenario/1\nname: again\naxis: rotary\nreference: {log: bench.mcap, to_s: 0.999}\n"
    )
    start = "start: {value: 5, unit: rad}\n"
    again.write_text(again.read_text().replace("reference:", start + "reference:"))
    _, second = play(again, braking, tmp_path)
    for name in ("reference", "position", "command", "position_true"):
        np.testing.assert_array_equal(second.main.signals[name], first.main.signals[name][:1000])


def test_the_same_scenario_gives_the_same_bytes(braking: Path, tmp_path: Path) -> None:
    text = (
        (READY / "random.yaml")
        .read_text()
        .replace("plants: 1000\n", "plants: 9\n")
        .replace("duration_s: 16", "duration_s: 0.5")
    )
    few = tmp_path / "few.yaml"
    few.write_text(text)
    outputs = []
    for _ in range(2):
        play(few, braking, tmp_path)
        outputs.append((tmp_path / "run.mcap").read_bytes())
    assert outputs[0] == outputs[1]


STEPS = "steps:\n  - {reference: {value: 40, unit: rad}, duration_s: 1}\n"
LOAD, FAULT = STEPS + "disturbances:\n  - {kind: ", STEPS + "sensor_faults:\n  - {kind: "
VOLTS, ONE = FAULT.replace("sensor", "drive: voltage\nsensor"), "{value: 1, unit: N m}"
HEAD = "format: scenario/1\nname: s\naxis: rotary\nstart: {value: 5, unit: rad}\n"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (STEPS + "  - {hold_s: 5}\n", 7, "steps[1].hold_s: found 5; allowed: a number >= 15"),
        (
            STEPS + "  - {ramp_to: {value: 70, unit: rad}, duration_s: 1}\n",
            7,
            "steps[1].ramp_to: found a path from 40.03 to 70 rad",
        ),
        (
            STEPS
            + "  - {sine: {amplitude: {value: 41, unit: rad}, frequency_hz: 1}, duration_s: 1}\n",
            7,
            "steps[1].sine: found a path from -1",
        ),
        (
            STEPS
            + "  - {sine: {amplitude: {value: 1, unit: rad}, frequency_hz: 500}, duration_s: 1}\n",
            7,
            "frequency_hz: found 500; allowed: below",
        ),
        (
            STEPS
            + "  - {sine: {amplitude: {value: 1, unit: m}, frequency_hz: 5}, duration_s: 1}\n",
            7,
            "unit 'm' does not measure position",
        ),
        (
            STEPS + "  - {duration_s: 1}\n",
            7,
            "steps[1]: found none of them; allowed: exactly one of reference, ramp_to, sine, "
            "hold_s",
        ),
        (
            STEPS + "variants: random\nplants: 0\n",
            8,
            "plants: found 0; allowed: a whole number >= 1",
        ),
        (STEPS + "plants: 10\n", 7, "required with `variants: random`"),
        (
            STEPS + "variants: random\nplants: 100000\n",
            5,
            "steps: requests 1e+08 samples in 100001 runs;",
        ),
        (
            LOAD + "step, effort: ONE, at_s: 1}\n",
            8,
            "at_s: found 1, after the end; allowed: below 1",
        ),
        (LOAD + "pulse, effort: ONE, at_s: 0.5}\n", 8, "a pulse needs duration_s"),
        (
            LOAD + "step, effort: {value: 1, unit: N}, at_s: 0}\n",
            8,
            "is not a unit of effort for a rotary axis",
        ),
        (LOAD + "puls, effort: ONE, at_s: 0}\n", 8, "did you mean 'pulse'?"),
        (
            LOAD + "sine, effort: ONE, at_s: 0}\n",
            8,
            "frequency_hz: required with kind sine",
        ),
        (
            LOAD + "pulse, effort: ONE, at_s: 0.5, duration_s: 0.6}\n",
            8,
            "disturbances[0].duration_s: ends at 1.1 s, after the end; allowed: at most 1 s",
        ),
        (
            FAULT + "lost_counts, at_s: 2, counts: 3}\n",
            8,
            "sensor_faults[0].at_s: found 2, after the end",
        ),
        (
            FAULT + "lost_counts, at_s: 0.2, counts: 0}\n",
            8,
            "counts: found 0; allowed: a whole number other than 0",
        ),
        (
            FAULT + "lost_counts, at_s: 0.2}\n",
            8,
            "counts: required with kind lost_counts",
        ),
        (FAULT + "encoder_stuck, at_s: 0.2}\n", 8, "encoder_stuck needs until_s"),
        (
            FAULT + "encoder_stuck, at_s: 0.2, until_s: 0.1}\n",
            8,
            "until_s: found 0.1; allowed: after at_s, 0.2",
        ),
        (
            FAULT + "encoder_stuck, at_s: 0.2, until_s: 0.2001}\n",
            8,
            "until_s: lasts for 0.0001 s; allowed: at least one sample",
        ),
        (
            FAULT + "drive_gain, at_s: 0.2, gain_error: -1}\n",
            8,
            "gain_error: found -1; allowed: a number > -1",
        ),
        (
            FAULT + "drive_offset, at_s: 0.2, offset: {value: 1, unit: V}}\n",
            8,
            "unit 'V' does not measure current",
        ),
        (
            VOLTS + "drive_offset, at_s: 0.2, offset: {value: 1, unit: V}}\n",
            7,
            "drive: found voltage; allowed: current, the drive of",
        ),
        (
            STEPS + "drifts: {friction: [{at_s: 0, factor: 0}]}\n",
            7,
            "drifts.friction[0].factor: found 0; allowed: a number > 0 and <= 100",
        ),
        (
            STEPS + "drifts: {friction: [{at_s: 3, factor: 1}]}\n",
            7,
            "drifts.friction[0].at_s: found 3, after the end",
        ),
        (
            STEPS + "drifts: {wear: [{at_s: 3, factor: 1}]}\n",
            7,
            "drifts.wear: unknown key; allowed: friction, viscous, constant",
        ),
        (
            STEPS + "drifts: {viscous: [{at_s: 0.3, factor: 1}, {at_s: 0.3, factor: 2}]}\n",
            7,
            "drifts: viscous: found at_s 0.3 after 0.3; allowed: rising times",
        ),
        ("reference: {log: nothing.mcap}\n", 5, "reference.log: found"),
        (
            "reference: {log: x.csv, from_s: 3, to_s: 2}\n",
            5,
            "reference: to_s: found 2; allowed: after from_s, 3",
        ),
        (
            STEPS + "reference: {log: x.csv}\n",
            1,
            "found `steps` and `reference`; allowed: one of them",
        ),
    ],
)
def test_what_may_not_be_asked_names_line_and_key(
    text: str, line: int, words: str, tmp_path: Path
) -> None:
    rig = write_rig(tmp_path)
    rig["scenario"].write_text(HEAD + text.replace("ONE", ONE))
    result = run(
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        tmp_path / "run.mcap",
    )
    refused(result, 3, f"scenario.yaml:{line}: ", words)
    assert not (tmp_path / "run.mcap").exists()


def test_a_replayed_path_beyond_the_travel_is_refused(tmp_path: Path) -> None:
    rig = write_rig(tmp_path)
    shutil.copy(ROOT / "sample_logs/steps.csv", tmp_path)
    rig["scenario"].write_text(
        "format: scenario/1\nname: s\naxis: rotary\nreference: {log: steps.csv, channel: "
        "position, shift: {value: 20, unit: rad}}\n"
    )
    result = run(
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        tmp_path / "run.mcap",
    )
    refused(
        result,
        3,
        "scenario.yaml:4: reference: found a path from",
        "allowed: the travel of the bench, 0 to 63 rad",
    )


def test_the_log_that_is_replayed_is_an_input(tmp_path: Path) -> None:
    rig = write_rig(tmp_path)
    shutil.copy(ROOT / "sample_logs/steps.csv", tmp_path)
    rig["scenario"].write_text(
        "format: scenario/1\nname: s\naxis: rotary\nreference: {log: steps.csv, channel: "
        "position}\n"
    )
    result = run(
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        also_called(tmp_path / "steps.csv", ".mcap"),
    )
    refused(result, 3, "link_to_steps.mcap", "is an input")


def test_the_scenario_of_the_formats_page_is_one(tmp_path: Path) -> None:
    """Its examples have every key; a replay and a test without a controller stand in place of the
    steps."""
    page = (
        (ROOT / "docs/formats.md").read_text().partition("### Scenario")[2].partition("\n### ")[0]
    )
    whole, replay, torques, given, spread = (
        block.partition("\n```")[0] for block in page.split("```yaml\n")[1:]
    )
    example, other, played = (
        tmp_path / "example.yaml",
        tmp_path / "replay.yaml",
        tmp_path / "torques.yaml",
    )
    example.write_text(whole)
    varied = tmp_path / "varied.yaml"
    fixed = whole.replace("temperature: {value: 60, unit: degC}\n", "")  # `spread` has it as well
    varied.write_text(
        f"{fixed}\n{given}\n{spread}".replace("variants: random", "").replace("plants: 1000", "")
    )
    other.write_text("format: scenario/1\nname: replay\naxis: rotary\n" + replay)
    played.write_text("format: scenario/1\nname: torques\naxis: rotary\n" + torques)
    found = load(example, Scenario)
    left = {name for name in Scenario.__struct_fields__ if f"\n{name}:" not in f"\n{whole}"}
    assert left == {"reference", "sources", "duration_s", "given", "spread", "examples"}
    drawn = load(varied, Scenario)
    assert drawn.given["coulomb"].value == 0.1
    assert all(f"\n  {name}:" in spread for name in Spread.__struct_fields__)
    assert drawn.spread.parameters["coulomb"].high == 60.0
    assert {fault.kind for fault in drawn.spread.sensor_faults} == {
        fault.kind for fault in found.sensor_faults
    }
    assert [signal.kind for signal in load(played, Scenario).sources["motor"]] == [
        "step",
        "pulse",
        "ramp",
        "sine",
    ]
    assert len(found.steps) == 4
    assert {fault.kind for fault in found.sensor_faults} == {
        "lost_counts",
        "encoder_stuck",
        "encoder_invalid",
        "drive_offset",
        "drive_gain",
    }
    assert load(other, Scenario).reference.shift.value == 5.0


def test_a_scenario_survives_writing_and_reading(tmp_path: Path) -> None:
    for path in READY.glob("*.yaml"):
        copy = tmp_path / path.name
        copy.write_text(to_yaml(load(path, Scenario)))
        assert load(copy, Scenario) == load(path, Scenario)
