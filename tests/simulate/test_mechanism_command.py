"""`frictool simulate mechanism.yaml` on a command line: what is written and told, tests of
`excite`, the verdict, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import CommandResult, run
from studies.rigs.clutch_model import ROOT
from studies.rigs.step_scenario import controller, scenario
from tests.support.command_line import refused
from tests.support.simulated_mechanisms import CLUTCH, GEARED, ONE_BLOCK, one_axis, write_text

READY = ROOT / "configs/clutch/scenarios"
TORQUES = """\
format: scenario/1
name: torques
axis: rotary
duration_s: 0.3
drive_noise: 0.05
sources:
  motor:
    - {kind: step, level: {value: 8, unit: A}, at_s: 0.0203}
    - {kind: step, level: {value: -8, unit: A}, at_s: 0.15}
"""


@pytest.fixture
def rig(tmp_path: Path) -> dict[str, Path]:
    texts = {
        "mechanism": GEARED,
        "controller": to_yaml(controller()),
        "scenario": to_yaml(scenario(drive_noise=0.05)),
        "torques": TORQUES,
    }
    return {name: write_text(tmp_path, f"{name}.yaml", text) for name, text in texts.items()}


def closed(rig: dict[str, Path], output: Path | str, *more: object) -> CommandResult:
    return run(
        "simulate",
        rig["mechanism"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        output,
        *more,
    )


def test_a_closed_loop_is_told_block_by_block(rig: dict[str, Path], tmp_path: Path) -> None:
    result = closed(rig, tmp_path / "run.mcap")
    assert result.code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[0] == "steps: 1 stream of 1200 samples, 1.2 s"
    told = {line.split()[0]: line.split() for line in lines[2:]}
    assert told["/axis"][-2:] == ["at", "rest"]
    assert {"/mechanism", "rotor", "load", "pair:", "events:", "energy"} <= set(told)
    assert float(told["energy"][-1]) < 1e-6
    log = read_mcap(tmp_path / "run.mcap")
    assert [stream.topic for stream in log.streams] == ["/axis", "/mechanism"]
    command = (
        "frictool simulate mechanism.yaml --controller controller.yaml --scenario scenario.yaml"
    )
    assert log.metadata["provenance"]["command"] == command
    assert closed(rig, "-").out == (tmp_path / "run.mcap").read_bytes()


def test_sources_alone_with_events_as_json(rig: dict[str, Path], tmp_path: Path) -> None:
    events = tmp_path / "events.csv"
    result = run(
        "simulate",
        rig["mechanism"],
        "--scenario",
        rig["torques"],
        "--events",
        events,
        "--json",
        "-o",
        tmp_path / "run.mcap",
    )
    assert result.code == 0, result.stderr
    found = json.loads(result.stdout)
    assert "final_position" in found["streams"][0]
    (blocks,) = found["mechanisms"]
    assert [row["block"] for row in blocks["blocks"]] == ["rotor", "load"]
    assert 0.0 < blocks["blocks"][0]["stuck"] < 1.0
    rows = [line.split(",") for line in events.read_text().splitlines()]
    assert rows[0] == ["time_s", "plant", "element", "event", "speed"]
    assert len(rows) - 1 == sum(blocks["events"].values())
    first = next(row for row in rows[1:] if row[3] == "breaks away")
    # i(t) = 8 (1 - exp(-t/3 ms)) reaches 0.044 N m over 13.4 mN m/A
    assert float(first[0]) == pytest.approx(
        0.0203 - 3e-3 * np.log(1.0 - 0.044 / 13.4e-3 / 8.0), abs=1e-7
    )
    assert "reference" not in read_mcap(tmp_path / "run.mcap").main.signals


def test_the_report_judges_the_axis_and_info_lists_the_blocks(
    rig: dict[str, Path], tmp_path: Path
) -> None:
    closed(rig, tmp_path / "run.mcap")
    spec = ROOT / "configs/clutch/spec.yaml"
    found = json.loads(run("report", tmp_path / "run.mcap", "--spec", spec, "--json").stdout)
    assert {row["name"]: row["met"] for row in found["requirements"]}["static_error"] is True
    assert "/mechanism" not in json.dumps(found)
    shown = run("info", tmp_path / "run.mcap").stdout
    assert "/mechanism.load_velocity" in shown
    assert (
        run(
            "convert",
            tmp_path / "run.mcap",
            "--stream",
            "/mechanism",
            "-o",
            tmp_path / "blocks.csv",
        ).code
        == 0
    )
    assert "pair_contact" in (tmp_path / "blocks.csv").read_text().partition("\n")[0]


@pytest.mark.parametrize(
    ("name", "cuts", "topics"),
    [
        (
            "mechanism",
            {"plants: 20\n": "plants: 2\n", "duration_s: 16.2": "duration_s: 1.1"},
            ["/axis", "/axis/p1", "/axis/p2"],
        ),
        ("rebound", {"duration_s: 300": "duration_s: 0.4"}, ["/axis"]),
    ],
)
def test_the_ready_scenarios_of_the_exhaustive_clutch(
    rig: dict[str, Path], tmp_path: Path, name: str, cuts: dict[str, str], topics: list[str]
) -> None:
    """Fewer plants and shorter holds than theirs."""
    text = (READY / f"{name}.yaml").read_text()
    for old, new in cuts.items():
        assert old in text
        text = text.replace(old, new)
    cut = write_text(tmp_path, "cut.yaml", text)
    result = run(
        "simulate",
        CLUTCH,
        "--controller",
        rig["controller"],
        "--scenario",
        cut,
        "-o",
        tmp_path / "run.mcap",
        "--json",
    )
    assert result.code == 0, result.stderr
    found = json.loads(result.stdout)
    assert [row["topic"] for row in found["streams"]] == topics
    assert all("blocks.rotor.inertia" in row["plant"] for row in found["streams"][1:])
    for one in found["mechanisms"]:
        assert abs(one["energy_J"]["residual"]) < 1e-6 * one["energy_J"]["input"]


def test_a_test_of_excite_is_played_as_to_the_axis(tmp_path: Path) -> None:
    """Steps under the bench's loop and breakaway ramps, to one block and to the model of the same
    axis: the same counts."""
    block, model = (
        write_text(tmp_path, "block.yaml", ONE_BLOCK),
        write_text(tmp_path, "model.yaml", to_yaml(one_axis())),
    )
    for kind, gains in (
        ("steps", ("--position-gain", "30", "--speed-gain", "0.1")),
        ("breakaway", ()),
    ):
        test = tmp_path / f"{kind}.mcap"
        assert (
            run(
                "excite", "--bench", ROOT / "configs/clutch/bench.yaml", "--kind", kind, "-o", test
            ).code
            == 0
        )
        logs = []
        for plant in (block, model):
            result = run(
                "simulate",
                plant,
                "--excitation",
                test,
                *gains,
                "--seed",
                "4",
                "-o",
                tmp_path / "log.mcap",
            )
            assert result.code == 0, result.stderr
            logs.append(read_mcap(tmp_path / "log.mcap").main.signals)
        assert set(logs[0]) == set(logs[1])
        np.testing.assert_allclose(logs[0]["position"], logs[1]["position"], atol=1e-9)
        np.testing.assert_allclose(logs[0]["current"], logs[1]["current"], atol=1e-5)
        assert np.ptp(logs[0]["position"]) > 5.0


@pytest.mark.parametrize(
    ("which", "old", "new", "words"),
    [
        (
            "controller",
            "delay_samples: 1\n",
            "delay_samples: 2\n",
            ("controller.yaml:8: delay_samples: found 2", "mechanism.yaml has 1"),
        ),
        (
            "scenario",
            "variants: nominal",
            "variants: vertices",
            ("variants: found vertices", "allowed for a mechanism: nominal, random"),
        ),
        (
            "scenario",
            "steps:",
            "sources: {motor: []}\nsteps:",
            ("sources.motor: is commanded by the controller",),
        ),
        (
            "scenario",
            "steps:",
            "sources: {hands: []}\nsteps:",
            ("sources.hands: ", "allowed: motor, hand"),
        ),
        (
            "mechanism",
            "drive: current, constant: {value: 13.4e-3, unit: N m/A}, limit: {value: 50, unit: A}",
            "drive: effort",
            ("drive: ",),
        ),
        (
            "mechanism",
            "control: {source: motor, sensor: encoder}",
            "",
            ("mechanism.yaml:", "sources: found motor, hand"),
        ),
        (
            "mechanism",
            "sensor: encoder}",
            "sensor: encoder, load: fly}",
            ("mechanism.yaml:", "control.load: found 'fly'"),
        ),
        ("mechanism", "ratio: 0.5", "ratio: 0", ("mechanism.yaml:", "links.pair.ratio")),
    ],
)
def test_documents_that_do_not_fit_are_one_line(
    rig: dict[str, Path], tmp_path: Path, which: str, old: str, new: str, words: tuple[str, ...]
) -> None:
    text = rig[which].read_text()
    if which == "scenario" and old not in text:
        text += "variants: nominal\n"
    assert old in text
    rig[which].write_text(text.replace(old, new, 1))
    refused(closed(rig, tmp_path / "run.mcap"), 3, *words)
    assert not (tmp_path / "run.mcap").exists()


def test_a_scenario_without_controller_is_told_from_one_with(
    rig: dict[str, Path], tmp_path: Path
) -> None:
    out = tmp_path / "run.mcap"
    refused(
        run("simulate", rig["mechanism"], "--scenario", rig["scenario"], "-o", out),
        3,
        "steps: is for a test with a controller",
        "give --controller",
    )
    both = run(
        "simulate",
        rig["mechanism"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["torques"],
        "-o",
        out,
    )
    refused(both, 3, "duration_s: belongs to a test without a controller")
    model = write_text(tmp_path, "model.yaml", to_yaml(one_axis()))
    plain = run(
        "simulate",
        model,
        "--controller",
        rig["controller"],
        "--scenario",
        rig["torques"],
        "-o",
        out,
    )
    refused(plain, 3, "sources: belongs to a mechanism")
    alone = run("simulate", model, "--scenario", rig["torques"], "-o", out)
    assert alone.code == 2
    assert "--controller" in alone.stderr
    listed = run(
        "simulate",
        model,
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "--events",
        "e.csv",
        "-o",
        out,
    )
    assert listed.code == 2
    assert "--events" in listed.stderr


HOIST = """\
format: mechanism/1
name: self-locking hoist lowering
blocks:
  m: {inertia: {value: 1.0e-5, unit: kg m^2}}
  d: {inertia: {value: 5, unit: kg m^2}}
links:
  worm: {kind: gear, between: [m, d], ratio: 0.02, internal: true, efficiency: 0.4}
sources:
  u: {on: m, drive: effort}
  g: {on: d, drive: effort, effort: {value: -1, unit: N m}}
sensors: {e: {on: m}}
"""
LOWER = """\
format: scenario/1
name: lower
axis: rotary
duration_s: 0.3
sources:
  u:
    - {kind: ramp, level: {value: -0.05, unit: N m}, duration_s: 0.2}
"""
TWO_WORMS = """\
format: mechanism/1
name: one motor, two self-locking worms
blocks:
  a: {inertia: {value: 1, unit: kg m^2}}
  b: {inertia: {value: 1, unit: kg m^2}}
  c: {inertia: {value: 1, unit: kg m^2}}
links:
  one: {kind: gear, between: [a, b], ratio: 0.05, efficiency: 0.4}
  two: {kind: gear, between: [a, c], ratio: 0.05, efficiency: 0.4}
sources: {u: {on: a, drive: effort}}
"""


def test_a_self_locking_hoist_is_lowered_as_with_a_stiff_link(tmp_path: Path) -> None:
    """Once the ramp has ended the motor drives the drum at -19.96 rad/s^2; with a link of 1e5 N
    m/rad the way is the same within 0.1 %."""
    scenario_file, ways = write_text(tmp_path, "lower.yaml", LOWER), []
    soft = (
        "efficiency: 0.4, compliance: {stiffness: {value: 1.0e+5, unit: N m/rad}, damping: "
        "{value: 100, unit: N m s/rad}}"
    )
    for name, text in (("rigid", HOIST), ("soft", HOIST.replace("efficiency: 0.4", soft))):
        output = tmp_path / f"{name}.mcap"
        result = run(
            "simulate",
            write_text(tmp_path, f"{name}.yaml", text),
            "--scenario",
            scenario_file,
            "-o",
            output,
        )
        assert result.code == 0, result.stderr
        ways.append(read_mcap(output).streams[1].signals)
    speed = ways[0]["m_velocity"]
    assert (speed[-1] - speed[-51]) / 0.05 == pytest.approx(-19.96, abs=0.005)
    assert ways[0]["m_position"][-1] == pytest.approx(ways[1]["m_position"][-1], rel=1e-3)


def test_one_block_drives_two_self_locking_links(tmp_path: Path) -> None:
    """(J + 2 r^2 J/eta) x = u; the reading is that of every command."""
    text = write_text(tmp_path, "two.yaml", TWO_WORMS)
    torque = LOWER.replace(
        "kind: ramp, level: {value: -0.05, unit: N m}, duration_s: 0.2",
        "kind: step, level: {value: 1, unit: N m}",
    )
    result = run(
        "simulate",
        text,
        "--scenario",
        write_text(tmp_path, "torque.yaml", torque),
        "-o",
        tmp_path / "two.mcap",
    )
    assert result.code == 0, result.stderr
    speed = read_mcap(tmp_path / "two.mcap").main.signals["a_velocity"]
    assert speed[-1] - speed[0] == pytest.approx(
        (speed.size - 1) * 1e-3 / (1.0 + 2.0 * 0.05**2 / 0.4), rel=1e-9
    )
    assert run("equations", text).code == 0
