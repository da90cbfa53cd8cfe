"""`frictool observe design` from the command line: what it prints, what it writes, and when it
refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from frictool.documents.observer import Observer
from frictool.documents.registry import load
from studies.command_line import run
from studies.rigs.clutch_model import ROOT
from tests.support.command_line import refused


@pytest.fixture
def model(tmp_path: Path) -> Path:
    shutil.copy(ROOT / "configs/clutch/nonlinear.yaml", tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def test_text_tells_modes_gamma_and_what_the_certificate_does_not_hold(model: Path) -> None:
    result = run(
        "observe",
        "design",
        model,
        "--kind",
        "multiplicative",
        "--intervals",
        "4",
        "-o",
        model.parent / "observer.yaml",
    )
    assert result.code == 0
    stored = load(model.parent / "observer.yaml", Observer)
    assert stored.switched is not None
    assert (
        f"gamma {stored.switched.gamma:.4g} ({stored.switched.smallest_gamma:.4g} without a decay)"
        in result.stdout
    )
    assert f"largest gain in simulation {stored.switched.simulated_gain:.4g}" in result.stdout
    assert "9 modes, 31 transitions, stuck below 10 rad/s" in result.stdout
    assert (
        sum(line.split("  ")[0] in map(str, range(-4, 5)) for line in result.stdout.splitlines())
        == 9
    )
    for note in (
        "the encoder is coarse",
        "can reverse without passing mode 0",
        "the error of alpha is constant",
        "viscous friction above a knee",
    ):
        assert note in result.stdout
    assert (
        stored.provenance.command
        == "frictool observe design model.yaml --kind multiplicative --intervals 4"
    )
    assert [source.name for source in stored.provenance.inputs] == ["model.yaml"]


def test_json_tells_what_the_document_holds_and_the_same_inputs_give_the_same_bytes(
    model: Path,
) -> None:
    words = (
        "observe",
        "design",
        model,
        "--kind",
        "additive",
        "--inertia",
        "105.6 g cm^2",
        "--switch-speed",
        "100rad/s",
    )
    result = run(*words, "--json", "-o", model.parent / "observer.yaml")
    told, stored = json.loads(result.stdout), load(model.parent / "observer.yaml", Observer)
    assert stored.switched is not None
    assert told["kind"] == stored.kind == "additive"
    assert told["gamma"] == stored.switched.gamma
    assert told["inertia"] == stored.inertia.value == pytest.approx(1.056e-5)
    assert told["switch_speed"] == 100.0
    assert [mode["index"] for mode in told["modes"]] == [-1, 0, 1]
    assert all(0.0 < mode["spectral_radius"] < told["decay"] for mode in told["modes"])
    assert told["transitions"] == [list(pair) for pair in stored.switched.transitions]
    to_stdout = run(*words, "-o", "-")
    assert to_stdout.out == (model.parent / "observer.yaml").read_bytes()


def test_options_reach_the_document(model: Path) -> None:
    words = (
        "observe",
        "design",
        model,
        "--kind",
        "additive",
        "--weights",
        "1,50,0.01",
        "--decay",
        "0.99",
        "--stuck-speed",
        "zero",
    )
    assert run(*words, "-o", model.parent / "observer.yaml").code == 0
    switched = load(model.parent / "observer.yaml", Observer).switched
    assert switched is not None
    assert (switched.weights, switched.decay, switched.stuck_speed) == (
        (1.0, 50.0, 0.01),
        0.99,
        0.0,
    )


def test_a_tracking_observer(model: Path) -> None:
    result = run(
        "observe",
        "design",
        model,
        "--kind",
        "tracking",
        "--bandwidth",
        "150",
        "-o",
        model.parent / "observer.yaml",
    )
    assert result.code == 0
    stored = load(model.parent / "observer.yaml", Observer)
    assert stored.tracking is not None
    assert stored.tracking.bandwidth_rad_s == 150.0
    assert "tracking observer, 1 ms, bandwidth 150 rad/s" in result.stdout
    assert (
        json.loads(
            run(
                "observe", "design", model, "--kind", "tracking", "--drive-noise", "500mA", "--json"
            ).stdout
        )["bandwidth_rad_s"]
        > 0.0
    )


def test_no_solution_is_exit_4_and_no_file(model: Path) -> None:
    target = model.parent / "observer.yaml"
    words = ("observe", "design", model, "-o", target, "--kind")
    refused(
        run(*words, "multiplicative", "--decay", "0.3", "--intervals", "4"),
        4,
        "no gains satisfy the inequalities with a decay of 0.3",
        "decay nearer to 1",
    )
    refused(
        run(*words, "multiplicative", "--intervals", "2"),
        4,
        "the forward friction has an extremum at",
        "allowed: at least 3",
    )
    model.write_text(model.read_text().replace("    top_speed: {value: 400, unit: rad/s}\n", ""))
    refused(run(*words, "additive"), 4, "give --switch-speed, such as 10rad/s")
    assert not target.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("--kind", "additive", "--intervals", "3"),
            "--intervals is not for --kind additive; allowed: --switch-speed",
        ),
        (
            ("--kind", "tracking", "--decay", "0.9"),
            "--decay is not for --kind tracking; allowed: --bandwidth, --drive-noise, --inertia",
        ),
        (("--kind", "additive", "--weights", "1,100"), "found '1,100'; allowed: three numbers"),
        (("--kind", "additive", "--weights", "1,0,1"), "the second (speed) above 0"),
        (
            ("--kind", "additive", "--inertia", "1.1e-5 kg"),
            "--inertia: unit 'kg' does not measure inertia of a rotary axis",
        ),
        (
            ("--kind", "additive", "--inertia", "-1"),
            "--inertia: found '-1'; allowed: above 0 kg m^2",
        ),
        (
            ("--kind", "additive", "--switch-speed", "fast"),
            "--switch-speed: found 'fast'; allowed: a number with or without its unit, such as 10",
        ),
        (("--kind", "additive", "--decay", "1.1"), "--decay"),
        (
            ("--kind", "additive", "--switch-speed", "1e9rad/s"),
            "found 1e+09 rad/s; allowed: below the bench's mechanics.top_speed, 400 rad/s",
        ),
        (
            ("--kind", "tracking", "--bandwidth", "1e9"),
            "found 1e+09 rad/s; allowed: above 0 and at most 1000 rad/s",
        ),
        (("--kind", "kalman"), "'kalman' is not one of"),
        ((), "Missing option '--kind'"),
    ],
)
def test_a_wrong_command_line_is_exit_2(words: tuple[str, ...], said: str, model: Path) -> None:
    result = run("observe", "design", model, *words)
    assert result.code == 2
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_what_is_no_model_is_exit_3(tmp_path: Path) -> None:
    refused(
        run("observe", "design", tmp_path / "absent.yaml", "--kind", "additive"), 3, "absent.yaml"
    )
    refused(
        run("observe", "design", ROOT / "configs/clutch/spec.yaml", "--kind", "additive"),
        3,
        "spec.yaml",
        "format",
    )
