"""`simulate --observer`, `observe loop`: the speed that a controller uses, in the log, in the
exported C, and what is refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.controller import Controller
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.simulate.compiled_target import COMPILERS
from frictool.typing import Vector
from frictool.verify.document_check import check_feedback
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.logged_plant import RECORD, LoggedPlant
from frictool.verify.plant_margins import PlantMargins
from studies.command_line import CommandResult, run
from studies.rigs.example_controllers import clutch_controller
from studies.rigs.step_scenario import scenario
from tests.support.command_line import refused
from tests.support.observed_loop import CLUTCH, by_speed, tracking


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """model.yaml, controller.yaml, observer.yaml, scenario.yaml."""
    documents = {
        "model": CLUTCH,
        "controller": by_speed(),
        "observer": tracking(),
        "scenario": scenario(40.0, 15.0, drive_noise=0.5),
    }
    for name, document in documents.items():
        (tmp_path / f"{name}.yaml").write_text(to_yaml(document))
    return tmp_path


def simulate(
    rig: Path, name: str, *more: str | Path, controller: str = "controller.yaml"
) -> CommandResult:
    words: list[str | Path] = [
        "simulate",
        rig / "model.yaml",
        "--controller",
        rig / controller,
        "--scenario",
        rig / "scenario.yaml",
    ]
    return run(*words, *more, "-o", rig / f"{name}.mcap")


def signals(rig: Path, name: str) -> dict[str, Vector]:
    return dict(read_mcap(rig / f"{name}.mcap").main.signals)


def rms_error(found: dict[str, Vector]) -> float:
    return float(np.sqrt(np.mean((found["velocity_estimated"] - found["velocity"]) ** 2)))


def test_the_loop_runs_on_the_observer_s_speed_and_the_log_has_it(rig: Path) -> None:
    assert simulate(rig, "difference").code == 0
    observed = simulate(rig, "observed", "--observer", rig / "observer.yaml")
    assert observed.code == 0
    assert "modulus margin" in observed.stderr
    one, other = signals(rig, "difference"), signals(rig, "observed")
    assert rms_error(other) < 0.5 * rms_error(one)
    assert not np.array_equal(one["command"], other["command"])
    assert not other["velocity"][-100:].any()  # at rest, within the band
    assert not other["command"][-100:].any()


def test_what_the_log_holds_without_an_observer_is_the_low_pass_of_the_difference(
    rig: Path,
) -> None:
    assert simulate(rig, "difference").code == 0
    found = signals(rig, "difference")
    shown, x = 0.0, 1000.0 * 1e-3
    quotient = np.diff(found["position"], prepend=found["position"][0]) / 1e-3
    for k in range(1, quotient.size):
        shown = (2.0 - x) / (2.0 + x) * shown + x / (2.0 + x) * (quotient[k] + quotient[k - 1])
        assert found["velocity_estimated"][k] == pytest.approx(shown, abs=1e-6)


def test_the_merged_document_runs_to_the_same_log(rig: Path) -> None:
    merged = rig / "merged.yaml"
    made = run(
        "observe",
        "loop",
        rig / "controller.yaml",
        "--observer",
        rig / "observer.yaml",
        "-o",
        merged,
    )
    assert made.code == 0, made.stderr
    document = load(merged, Controller)
    assert document.velocity.observer == tracking()
    assert [item.name for item in document.provenance.inputs] == [
        "controller.yaml",
        "observer.yaml",
    ]
    assert simulate(rig, "one", "--observer", rig / "observer.yaml").code == 0
    assert simulate(rig, "other", controller="merged.yaml").code == 0
    one, other = signals(rig, "one"), signals(rig, "other")
    assert all(one[name].tobytes() == other[name].tobytes() for name in one)


@pytest.mark.skipif(not any(map(shutil.which, COMPILERS)), reason="no C compiler on the PATH")
@pytest.mark.parametrize(
    "number", [pytest.param("double", marks=pytest.mark.accept), "float", "q31"]
)
def test_the_exported_code_in_the_loop_gives_the_same_log_bit_by_bit(
    rig: Path, number: str
) -> None:
    assert (
        run(
            "observe",
            "loop",
            rig / "controller.yaml",
            "--observer",
            rig / "observer.yaml",
            "-o",
            rig / "merged.yaml",
        ).code
        == 0
    )
    exported = run(
        "export", rig / "merged.yaml", "--lang", "c", "--number", number, "-o", rig / "c"
    )
    assert exported.code == 0, exported.stderr
    assert simulate(rig, "here", "--number", number, controller="merged.yaml").code == 0
    assert simulate(rig, "there", "--target", rig / "c", controller="merged.yaml").code == 0
    here, there = signals(rig, "here"), signals(rig, "there")
    assert all(here[name].tobytes() == there[name].tobytes() for name in here)
    assert here["velocity_estimated"].any()


def test_a_margin_below_the_specified_one_is_told_by_simulate_and_refused_as_a_document(
    rig: Path,
) -> None:
    controller = by_speed()
    verified = msgspec.structs.replace(controller.verified, modulus_margin_specified=0.55)
    (rig / "controller.yaml").write_text(
        to_yaml(msgspec.structs.replace(controller, verified=verified))
    )
    (rig / "observer.yaml").write_text(to_yaml(tracking(70.0)))
    told = simulate(rig, "slow", "--observer", rig / "observer.yaml")
    assert told.code == 0
    assert "below the 0.55 that was specified" in told.stderr
    command: list[str | Path] = [
        "observe",
        "loop",
        rig / "controller.yaml",
        "--observer",
        rig / "observer.yaml",
    ]
    refused(
        run(*command, "-o", rig / "merged.yaml"),
        4,
        "controller.yaml",
        "modulus margin",
        "--modulus-margin",
    )
    assert not (rig / "merged.yaml").exists()
    assert run(*command, "--modulus-margin", "0.1", "-o", rig / "merged.yaml").code == 0
    assert load(rig / "merged.yaml", Controller).verified.modulus_margin_specified == 0.1


def test_an_unstable_loop_ends_with_exit_code_4_and_no_log(rig: Path) -> None:
    (rig / "controller.yaml").write_text(to_yaml(by_speed(gain=8e-3, integral_time=0.02)))
    (rig / "observer.yaml").write_text(to_yaml(tracking(40.0)))
    refused(
        simulate(rig, "never", "--observer", rig / "observer.yaml"), 4, "unstable at vertex light"
    )
    assert not (rig / "never.mcap").exists()


def test_a_controller_without_a_speed_is_refused_in_a_line(rig: Path) -> None:
    (rig / "controller.yaml").write_text(to_yaml(clutch_controller()))
    refused(simulate(rig, "never", "--observer", rig / "observer.yaml"), 3, "uses no speed")


def test_options_that_exclude_each_other(rig: Path) -> None:
    both = simulate(rig, "never", "--observer", rig / "observer.yaml", "--target", rig)
    assert both.code == 2
    assert "observe loop" in both.stderr


def test_report_claims_no_margin_of_another_loop(rig: Path) -> None:
    (rig / "spec.yaml").write_text(
        "format: spec/1\nname: clutch\naxis: rotary\ndrive: current\nmodulus_margin: 0.3\n"
    )
    assert simulate(rig, "observed", "--observer", rig / "observer.yaml").code == 0
    command: list[str | Path] = [
        "report",
        rig / "observed.mcap",
        "--spec",
        rig / "spec.yaml",
        "--controller",
    ]
    refused(run(*command, rig / "controller.yaml"), 3, "tracking observer", "observe loop")
    merged = rig / "merged.yaml"
    assert (
        run(
            "observe",
            "loop",
            rig / "controller.yaml",
            "--observer",
            rig / "observer.yaml",
            "-o",
            merged,
        ).code
        == 0
    )
    assert simulate(rig, "observed", controller="merged.yaml").code == 0
    shown = run(*command, merged, "--json", "-o", rig / "page.html")
    (margin,) = [
        one for one in json.loads(shown.stdout)["requirements"] if one["name"] == "modulus_margin"
    ]
    document = load(merged, Controller)
    log, lag = read_mcap(rig / "observed.mcap"), document.bench.actuator.loop_time_constant_s
    plant = LoggedPlant.of_text(log.metadata[RECORD]["/axis"])
    assert plant is not None
    pairs = [(loop, point.rates) for loop in feedbacks_of(document) for point in plant.points()]
    checks = [check_feedback(loop, rates, lag, document.delay_samples) for loop, rates in pairs]
    assert margin["value"] == pytest.approx(min(one.modulus_margin for one in checks), rel=1e-5)
    assert margin["value"] != pytest.approx(
        PlantMargins(load(rig / "controller.yaml", Controller))(plant), rel=1e-2
    )
    assert "tracking observer of" in (rig / "page.html").read_text()


def test_report_lays_both_speeds_side_by_side(rig: Path) -> None:
    (rig / "spec.yaml").write_text(
        "format: spec/1\nname: clutch\naxis: rotary\ndrive: current\nresponse_time_95_s: 0.6\n"
    )
    assert simulate(rig, "difference").code == 0
    assert simulate(rig, "observed", "--observer", rig / "observer.yaml").code == 0
    logs = [rig / "difference.mcap", rig / "observed.mcap"]
    shown = run("report", *logs, "--spec", rig / "spec.yaml", "-o", rig / "page.html", "--json")
    assert shown.code in (0, 1)
    page = (rig / "page.html").read_text()
    assert "rms error of the speed used [rad/s]" in page
    assert "Error of the speed estimate" in page
    errors = [stream["velocity_error_rms"] for stream in json.loads(shown.stdout)["streams"]]
    assert errors == pytest.approx(
        [rms_error(signals(rig, name)) for name in ("difference", "observed")], rel=1e-9
    )
