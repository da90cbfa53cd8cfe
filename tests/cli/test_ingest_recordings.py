"""Recordings of other tools from the command line: a ROS 2 bag becomes a model."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from studies.rigs.sample_logs import TRUTH
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, measured
from tests.support.recordings import (
    CLUTCH,
    COLUMNS,
    PERIOD,
    START,
    Sent,
    joint_states,
    ros2_bag,
    ros2_mcap,
    stamp,
)
from tests.support.short_logs import first_part

SINES = ROOT / "sample_logs" / "sines.csv"
RESOLUTION = 2.0 * np.pi / 56


@pytest.fixture
def bench(tmp_path: Path) -> Path:
    path = tmp_path / "bench.yaml"
    path.write_text(CLUTCH.read_text().partition("columns:")[0] + COLUMNS)
    return path


def as_joint_states(csv: Path) -> list[Sent]:
    """A log of the bench as a driver publishes it, beside a joint that stands still; the recorder
    is late, and not evenly."""
    rows = np.loadtxt(csv, delimiter=",", skiprows=1)
    template = joint_states([0.0])[0]
    sent = []
    for k, (time, count, current) in enumerate(rows.tolist()):
        at = START + round(time * 1e9)
        content = {
            "header": {"stamp": stamp(at), "frame_id": ""},
            "name": ["gearbox", "clutch"],
            "position": [0.0, RESOLUTION * count],
            "velocity": [],
            "effort": [0.0, current],
        }
        sent.append(template._replace(time=at + 200_000 + 1000 * (k % 7), content=content))
    return sent


def test_a_ros_2_bag_of_joint_states_ingests_and_identifies(tmp_path: Path, bench: Path):
    bag, log, reference = (
        tmp_path / "sines_bag.mcap",
        tmp_path / "sines.mcap",
        tmp_path / "reference.mcap",
    )
    sines = tmp_path / "sines.csv"
    sines.write_text(first_part("sines.csv"))
    bag.write_bytes(ros2_mcap(as_joint_states(sines)))
    result = run("ingest", bag, "--bench", bench, "-o", log)
    assert (result.code, result.stderr) == (0, "")
    assert "dated by header.stamp" in result.stdout
    assert run("ingest", sines, "--bench", CLUTCH, "-o", reference).code == 0
    ours, theirs = read_mcap(log).main, read_mcap(reference).main
    assert np.array_equal(ours.time, theirs.time)
    for name in ("position", "current", "effort"):
        assert (
            np.abs(ours.signals[name] - theirs.signals[name]).max()
            <= 1e-12 * np.abs(theirs.signals[name]).max()
        )
    found = run("identify", log, "--bench", bench, "--json")
    assert found.code == 0, found.stderr
    parameters = json.loads(found.stdout)["parameters"]
    assert {"viscous", "coulomb", "offset"} <= set(parameters)
    for name, interval in parameters.items():
        assert interval["low"] <= getattr(TRUTH, name) <= interval["high"], name


def test_the_folder_of_a_bag_is_an_input(tmp_path: Path, bench: Path):
    bench.write_text(
        bench.read_text().replace("clutch]", "arm]").replace("effort[arm]", "velocity[arm]")
    )
    ros2_bag(tmp_path / "bag", np.arange(50.0).tolist())
    target = tmp_path / "log.mcap"
    result = run("ingest", tmp_path / "bag", "--bench", bench, "-o", target)
    assert (result.code, result.stderr) == (0, "")
    log = read_mcap(target)
    assert log.metadata["provenance"]["input_1"].startswith("bag.db3 sha256:")
    assert log.metadata["time"] == {"epoch_ns": str(START), "/axis": "header.stamp"}
    assert log.main.signals["position"].tolist() == np.arange(50.0).tolist()


def test_a_recording_that_was_cut_is_refused_or_salvaged(tmp_path: Path, bench: Path):
    bag, target = tmp_path / "cut.mcap", tmp_path / "log.mcap"
    whole = ros2_mcap(as_joint_states(ROOT / "sample_logs" / "steps.csv"), chunk_size=20_000)
    bag.write_bytes(whole[: len(whole) // 2])
    refused(
        run("ingest", bag, "--bench", bench, "-o", target),
        3,
        "cut.mcap: is damaged or cut off at byte",
        "--salvage",
    )
    assert not target.exists()
    result = run("ingest", bag, "--bench", bench, "-o", target, "--salvage", "--json")
    assert result.code == 3
    (lost,) = json.loads(result.stdout)["lost"]
    shown = run("info", target, "--json")
    assert shown.code == 0
    facts = json.loads(shown.stdout)
    assert facts["lost"] == [lost]
    samples = facts["channels"][0]["samples"]
    assert 2000 < samples < 5000
    assert lost["start_s"] == pytest.approx((samples - 1) / 1000.0)


def test_a_recording_without_numbers_lists_what_is_there(tmp_path: Path, bench: Path):
    talker = measured("formats/ros2_talker.mcap")
    refused(
        run("ingest", talker, "--bench", bench, "-o", tmp_path / "x.mcap"),
        3,
        "has no topic with numbers",
        "/topic (std_msgs/msg/String)",
    )
    assert not (tmp_path / "x.mcap").exists()


def test_a_guess_of_a_bag_names_the_joint_that_moves_and_ingests(tmp_path: Path):
    bag, guessed, target = tmp_path / "run.mcap", tmp_path / "guess.yaml", tmp_path / "log.mcap"
    motion = np.sin(np.arange(50.0)).tolist()
    second_joint_moves = joint_states(motion, ("arm", "still"))
    for one in second_joint_moves:
        for values in (one.content["name"], one.content["position"]):
            values.reverse()
    bag.write_bytes(ros2_mcap(second_joint_moves))
    facts = json.loads(
        run("ingest", "--guess", bag, "--axis", "rotary", "-o", guessed, "--json").stdout
    )
    assert facts["columns"]["position"] == ["/joint_states.position[arm]", "rad"]
    assert facts["sample_period_s"] == 0.001
    assert run("ingest", bag, "--bench", guessed, "-o", target).code == 0
    assert read_mcap(target).main.signals["position"].tolist() == motion
    ros2_bag(tmp_path / "bag", motion)
    assert run("ingest", "--guess", tmp_path / "bag", "--axis", "rotary", "-o", guessed).code == 0
    assert "/joint_states.position[arm]" in guessed.read_text()


def test_parts_of_a_recording_are_told_and_info_says_what_dates_it(tmp_path: Path, bench: Path):
    bench.write_text(
        bench.read_text().replace("clutch]", "arm]").replace("effort[arm]", "velocity[arm]")
    )
    for part in range(2):
        start = START + part * 50 * PERIOD
        (tmp_path / f"run_{part}.mcap").write_bytes(
            ros2_mcap(joint_states((50.0 * part + np.arange(50.0)).tolist(), start=start))
        )
    target = tmp_path / "log.mcap"
    result = run(
        "ingest", tmp_path / "run_1.mcap", tmp_path / "run_0.mcap", "--bench", bench, "-o", target
    )
    assert (result.code, result.stderr) == (
        0,
        "run_0.mcap, run_1.mcap: read as parts of one recording\n",
    )
    shown = run("info", target)
    assert "dated by: /axis by header.stamp\n" in shown.stdout
    assert json.loads(run("info", target, "--json").stdout)["dated_by"] == {"/axis": "header.stamp"}
