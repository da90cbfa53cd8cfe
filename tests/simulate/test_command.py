"""`frictool simulate` on a command line: the log that it writes, the same bytes again, and one line
for each kind of bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of, load_of
from frictool.documents.model import Model
from frictool.documents.registry import load as read_document
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.plant.axis import POSITION, rest
from studies.command_line import CommandResult, run
from studies.references.event_integration import event_integration
from studies.rigs.clutch_model import ROOT
from studies.rigs.step_scenario import scenario, write_rig
from tests.support.command_line import also_called, refused

TOPICS = ["/axis", *(f"/axis/v{k:02d}" for k in range(1, 17))]


@pytest.fixture
def rig(tmp_path: Path) -> dict[str, Path]:
    return write_rig(tmp_path)


def simulate(rig: dict[str, Path], output: Path | str, *more: str) -> CommandResult:
    return run(
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
        output,
        *more,
    )


def test_writes_a_log_that_reads_back(rig: dict[str, Path], tmp_path: Path) -> None:
    result = simulate(rig, tmp_path / "run.mcap")
    assert result.code == 0, result.stderr
    assert result.stdout.splitlines()[0] == "steps: 17 streams, each of 1200 samples, 1.2 s"
    log = read_mcap(tmp_path / "run.mcap")
    assert [stream.topic for stream in log.streams] == TOPICS
    assert log.main.units["current"] == "A"
    assert log.metadata["log"]["kind"] == "simulated"
    assert (
        log.metadata["provenance"]["command"]
        == "frictool simulate model.yaml --controller controller.yaml --scenario scenario.yaml"
    )
    assert np.all(np.isfinite(log.main.signals["position"]))


def test_springs_gravity_and_ripple_are_integrated_with_the_motion(
    rig: dict[str, Path], tmp_path: Path
) -> None:
    """The logged commands, played to the model by scipy from the start of the run, give the logged
    positions to 1e-7 rad."""
    load = """laws:
  load:
    stiffness: {value: 0.002, unit: N m/rad, source: assumed}
    gravity: {sine: {value: 0.03, unit: N m, source: assumed}, cosine: {value: -0.01, unit: N m,
      source: assumed}}
    ripple:
      cycles: 1
      per: {value: 1.0, unit: rad}
      sine: {value: 0.01, unit: N m, source: assumed}
      cosine: {value: 0, unit: N m, source: assumed}
"""
    rig["model"].write_text(rig["model"].read_text() + load)
    rig["scenario"].write_text(to_yaml(scenario(40.0, 10.0, seconds=0.25)))
    result = simulate(rig, tmp_path / "run.mcap")
    assert result.code == 0, result.stderr
    log, model = read_mcap(tmp_path / "run.mcap").main.signals, read_document(rig["model"], Model)
    axis, weight, state = axis_of(model), load_of(model), rest(5.0)
    for k, position in enumerate(log["position_true"]):
        assert state[POSITION] == pytest.approx(position, rel=0.0, abs=1e-7)
        command = float(log["command"][k - 1]) if k else 0.0
        state[:4] = event_integration(axis, state, command, 1e-3, load=weight)
    assert np.ptp(log["position_true"]) > 20.0


def test_the_same_inputs_give_the_same_bytes_and_stdout_is_one_of_the_outputs(
    rig: dict[str, Path], tmp_path: Path
) -> None:
    simulate(rig, tmp_path / "a.mcap")
    piped = simulate(rig, "-")
    assert piped.out == (tmp_path / "a.mcap").read_bytes()


def test_json(rig: dict[str, Path], tmp_path: Path) -> None:
    found = json.loads(simulate(rig, tmp_path / "run.mcap", "--json").stdout)
    assert found["scenario"] == "steps"
    assert found["warnings"] == []
    assert [row["topic"] for row in found["streams"]] == TOPICS
    for row in found["streams"]:
        assert (row["samples"], row["duration_s"], row["at_rest"]) == (1200, 1.2, True)
        assert abs(row["final_error"]) < 2.2
        assert 0.0 < row["command_peak"] <= 50.0


@pytest.mark.parametrize("which", ["model", "controller", "scenario"])
@pytest.mark.parametrize("content", [None, b"", b"\x00\xff\x89MCAP0\r\n", b"format: nothing/1\n"])
def test_an_unusable_document_is_one_line_and_no_output(
    rig: dict[str, Path], tmp_path: Path, which: str, content: bytes | None
) -> None:
    rig[which].unlink() if content is None else rig[which].write_bytes(content)
    refused(simulate(rig, tmp_path / "run.mcap"), 3, f"{which}.yaml")
    assert not (tmp_path / "run.mcap").exists()


def test_a_misspelt_key_names_the_nearest(rig: dict[str, Path], tmp_path: Path) -> None:
    text = rig["scenario"].read_text()
    rig["scenario"].write_text(text.replace("variants:", "variant:"))
    refused(simulate(rig, tmp_path / "run.mcap"), 3, "scenario.yaml", "did you mean 'variants'?")
    assert not (tmp_path / "run.mcap").exists()


def test_documents_that_do_not_agree_name_the_file(rig: dict[str, Path], tmp_path: Path) -> None:
    text = rig["controller"].read_text()
    rig["controller"].write_text(text.replace("delay_samples: 1\n", "delay_samples: 2\n", 1))
    refused(
        simulate(rig, tmp_path / "run.mcap"),
        3,
        "controller.yaml:8: delay_samples: found 2",
        "model.yaml has 1",
    )
    assert not (tmp_path / "run.mcap").exists()


def test_an_input_is_not_overwritten(rig: dict[str, Path]) -> None:
    before = rig["model"].read_bytes()
    refused(simulate(rig, also_called(rig["model"], ".mcap")), 3, "is an input")
    assert rig["model"].read_bytes() == before


def test_help_opens_with_an_example() -> None:
    lines = run("simulate", "--help").stdout.splitlines()
    assert "Example:" in lines[2]
    assert "frictool simulate model.yaml" in lines[3]


@pytest.mark.parametrize("number", ["double", "q31"])
def test_a_lost_encoder_is_bridged_or_sets_the_fault(
    rig: dict[str, Path], tmp_path: Path, number: str
) -> None:
    """Three samples without a position change little; a fourth ends the drive for the rest of the
    run, and the command says so."""
    scenario = rig["scenario"].read_text()
    drives = []
    for samples in (0, 3, 4):
        lost = (
            f"sensor_faults:\n  - {{kind: encoder_invalid, at_s: 0.1, until_s: "
            f"{0.1 + 1e-3 * samples:g}}}\n"
            if samples
            else ""
        )
        rig["scenario"].write_text(scenario + lost)
        result = simulate(rig, tmp_path / f"{samples}.mcap", "--number", number)
        assert result.code == 0, result.stderr
        assert (
            "the controller reports a fault at 0.103 s, after more than 3 samples"
            in result.stdout + result.stderr
        ) == (samples == 4)
        log = read_mcap(tmp_path / f"{samples}.mcap")
        assert all(np.all(np.isfinite(values)) for values in log.main.signals.values())
        drives.append(log.main.signals["command"])
        judged = json.loads(
            run(
                "report",
                tmp_path / f"{samples}.mcap",
                "--spec",
                ROOT / "configs/clutch/spec.yaml",
                "--json",
            ).stdout
        )
        (overshoot,) = (row for row in judged["requirements"] if row["name"] == "overshoot")
        assert (overshoot["met"] is None) == (samples == 4)
        assert ("reports a fault at 0.103 s" in (overshoot["reason"] or "")) == (samples == 4)
    assert np.array_equal(drives[0][:100], drives[2][:100])
    assert drives[1][103:].any()
    assert not drives[2][103:].any()
