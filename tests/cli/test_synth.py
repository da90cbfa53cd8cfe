"""`frictool synth` from the command line: what it prints, what it writes, and when it refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from frictool.documents.controller import Controller
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.command_line import also_called, refused

RIG = ROOT / "configs/clutch"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "model.yaml").write_text(to_yaml(clutch_model()))
    shutil.copy(RIG / "spec.yaml", tmp_path)
    shutil.copy(RIG / "designs/speed.yaml", tmp_path / "design.yaml")
    return tmp_path


def _arguments(folder: Path) -> list[str | Path]:
    return [
        "synth",
        folder / "model.yaml",
        "--spec",
        folder / "spec.yaml",
        "--design",
        folder / "design.yaml",
        "--vertices-only",
        "--no-play",
    ]


def test_json_tells_what_the_document_holds_and_the_same_inputs_give_the_same_bytes(
    folder: Path,
) -> None:
    result = run(*_arguments(folder), "-o", folder / "controller.yaml", "--json")
    assert result.code == 0
    to_stdout = run(*_arguments(folder), "-o", "-")
    assert to_stdout.out == (folder / "controller.yaml").read_bytes()
    for words in (
        "1 sample of delay",
        " rad^0.5/s by sqrt(F/J), band 2 rad,",
        "\n        kg m^2     N m s/rad  N m        N m/A\nv01 ",
    ):
        assert words in to_stdout.stderr
    told = json.loads(result.stdout)
    stored = load(folder / "controller.yaml", Controller)
    assert told["gamma"] == stored.verified.gamma_asked
    assert told["gamma_verified"] == stored.verified.gamma_verified
    assert told["order"] == len(stored.linear.discrete.a)
    assert told["sample_period_s"] == 0.001
    assert len(told["vertices"]) == 16
    assert all(vertex["stable"] and vertex["modulus_margin"] >= 0.5 for vertex in told["vertices"])
    assert (
        stored.provenance.command
        == "frictool synth model.yaml --spec spec.yaml --design design.yaml --vertices-only"
    )
    assert [source.name for source in stored.provenance.inputs] == [
        "model.yaml",
        "spec.yaml",
        "design.yaml",
    ]


def test_a_design_that_is_not_verified_is_exit_4_and_no_file(folder: Path) -> None:
    spec = (folder / "spec.yaml").read_text()
    (folder / "spec.yaml").write_text(spec.replace("modulus_margin: 0.5", "modulus_margin: 0.95"))
    result = run(*_arguments(folder), "-o", folder / "controller.yaml")
    refused(
        result,
        4,
        "not verified",
        "vertex v",
        "modulus margin",
        "(inertia 1.11e-05 kg m^2, viscous ",
        " N m/A) with 1 sample of delay;",
    )
    assert not (folder / "controller.yaml").exists()


def test_documents_of_another_rig_are_refused(folder: Path) -> None:
    shutil.copy(ROOT / "configs/emps/spec.yaml", folder / "spec.yaml")
    refused(run(*_arguments(folder)), 3, "axis: found linear")


def test_a_picture_over_another_file_of_the_command_is_refused_at_once(folder: Path) -> None:
    design = (folder / "design.yaml").read_text()
    (folder / "design.yaml").write_text(f"{design}\nrelax: auto\n")
    controller = folder / "controller.yaml"
    same = run(*_arguments(folder), "-o", folder / "same", "--plot", folder / "same")
    assert same.code == 2
    assert "-o and --plot have the same name" in same.stderr
    refused(
        run(
            *_arguments(folder),
            "-o",
            controller,
            "--plot",
            also_called(folder / "spec.yaml", ".svg"),
        ),
        3,
        "is an input",
    )
    assert not controller.exists()


@pytest.mark.parametrize(
    ("file", "old", "new", "code", "words"),
    [
        (
            "design",
            "band: {value: 2, unit: rad}",
            "band: {value: 0.1, unit: rad}",
            3,
            ["position_law.band", "0.1 rad", "at least the encoder's"],
        ),
        (
            "design",
            "band: {value: 2, unit: rad}",
            "band: {value: 2.5, unit: rad}",
            3,
            ["2.5 rad", "at most static_error", "2 rad"],
        ),
        (
            "spec",
            "static_error: {value: 2,",
            "static_error: {value: 1,",
            3,
            ["found 2 rad", "at most static_error", "1 rad"],
        ),
        (
            "spec",
            "_95_s: 0.22",
            "_95_s: 0.04",
            4,
            [
                "found 0.04 s",
                "at least 0.077",
                "for a step of 40 rad",
                "inertia 1.53e-05",
                "actuator.limit",
            ],
        ),
        (
            "spec",
            "drive_peak: {value: 50, unit: A}",
            "drive_peak: 10",
            3,
            ["drive_peak: found 10", "write {value: 10, unit: A}"],
        ),
    ],
)
def test_what_encoder_and_drive_cannot_give_is_refused(
    folder: Path, file: str, old: str, new: str, code: int, words: list[str]
) -> None:
    text = (folder / f"{file}.yaml").read_text()
    assert old in text
    (folder / f"{file}.yaml").write_text(text.replace(old, new))
    refused(run(*_arguments(folder), "-o", folder / "controller.yaml"), code, *words)
    assert not (folder / "controller.yaml").exists()


@pytest.mark.parametrize(
    ("file", "old", "new", "place"),
    [
        (
            "design",
            "band: {value: 2, unit: rad}",
            "band: {value: 0.1, unit: rad}",
            ("design", "band: {value"),
        ),
        (
            "spec",
            "static_error: {value: 2,",
            "static_error: {value: 1,",
            ("design", "band: {value"),
        ),
        ("spec", "_95_s: 0.22", "_95_s: 0.04", ("spec", "response_time_95_s:")),
        (
            "design",
            "recentring: 1.05",
            "recentring: 1.05\nvelocity: {filter_rad_s: 1.0e+5}",
            ("design", "velocity:"),
        ),
    ],
)
def test_a_key_that_another_document_excludes_is_named_with_file_and_line(
    folder: Path, file: str, old: str, new: str, place: tuple[str, str]
) -> None:
    changed = folder / f"{file}.yaml"
    assert old in changed.read_text()
    changed.write_text(changed.read_text().replace(old, new))
    document = folder / f"{place[0]}.yaml"
    (line,) = [
        number
        for number, text in enumerate(document.read_text().splitlines(), start=1)
        if place[1] in text
    ]
    done = run(*_arguments(folder), "-o", folder / "controller.yaml")
    assert done.code in (3, 4)
    assert done.stderr.startswith(f"error: {document}:{line}: ")
