"""`frictool compare` on a command line: page, folder, JSON, and one line for each kind of bad
input."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from frictool.compare.text_view import KINDS, MEASURES, VERDICTS
from studies.command_line import run
from tests.support.command_line import also_called, refused

MASS = Path(__file__).parents[2] / "configs/mass"
FAST = ("--law", "stribeck", "--law", "lugre")


def test_json_is_one_object_with_the_figures_of_the_laws_asked_for() -> None:
    result = run("compare", MASS / "friction.yaml", *FAST, "--json")
    assert result.code == 0, result.stderr
    view = json.loads(result.stdout)
    assert list(view["laws"]) == ["stribeck", "lugre"]
    assert view["laws"]["stribeck"]["stick_slip"]["sticks"] == 9
    assert view["laws"]["stribeck"]["stick_slip"]["first_breakaway_s"] == pytest.approx(
        7.5, abs=1e-9
    )
    assert view["laws"]["lugre"]["drift"]["z_max_units"] == pytest.approx(86.0, rel=0.01)
    assert view["laws"]["lugre"]["verdicts"] == {
        "stick_slip": "+",
        "limit_cycle": "+",
        "presliding": "±",
        "drift": "-",
    }
    assert {(d["table"], d["law"], d["row"]) for d in view["differences"]} >= {
        ("2.1", "stribeck", "non_drift")
    }


def test_a_folder_gets_the_page_and_the_figures_and_stdout_the_same_page(tmp_path: Path) -> None:
    command = ("compare", MASS / "friction.yaml", "--law", "svc")
    result = run(*command, "-o", tmp_path / "laws")
    piped = run(*command, "-o", "-")
    assert piped.out == (tmp_path / "laws/index.html").read_bytes()
    assert piped.out.startswith(b"<!DOCTYPE html>")
    assert result.code == 0, result.stderr
    assert sorted(path.name for path in (tmp_path / "laws").iterdir()) == [
        "compare.json",
        "index.html",
    ]
    assert "svc" in json.loads((tmp_path / "laws/compare.json").read_text())["laws"]
    page = (tmp_path / "laws/index.html").read_text()
    assert "frictool compare friction.yaml --law svc" in page
    for explanation in (*MEASURES, *VERDICTS, *KINDS):
        assert explanation in page
        assert explanation in result.stdout


def test_the_printed_table_is_refused_and_allowed(tmp_path: Path) -> None:
    words = ("m Sigma > u_max T_e", "0.0001 N s", "0.0002 N s", "--allow")
    refused(
        run("compare", MASS / "table_3_1.yaml", "-o", tmp_path / "out.html"),
        3,
        "table_3_1.yaml",
        *words,
    )
    assert not (tmp_path / "out.html").exists()
    coarse = tmp_path / "coarse.yaml"
    text = (MASS / "table_3_1.yaml").read_text()
    coarse.write_text(text.replace("step_s: 1e-4", "step_s: 4e-4"))
    allowed = run("compare", coarse, "--law", "hybrid_a", "--allow", "--json")
    assert allowed.code == 0
    assert allowed.stderr.count("\n") == 1
    assert allowed.stderr.startswith("warning: m Sigma")
    assert json.loads(allowed.stdout)["laws"]["hybrid_a"]["verdicts"]["stick_slip"] == "+"
    assert (
        run("compare", MASS / "table_3_1.yaml", "--law", "stribeck", "--json").stderr == ""
    )  # no hybrid version, no rule


def test_a_model_of_an_actuator_is_compared_by_similarity(tmp_path: Path) -> None:
    bench = (MASS.parent / "clutch/bench.yaml").read_text()
    document = "\n".join(
        [
            "format: model/1\nname: clutch\naxis: rotary\nlaw: coulomb\nmethod: test\nconfidence: "
            "0.95\nbench:",
            *(f"  {line}" for line in bench.splitlines() if not line.startswith("#")),
            "parameters:",
            "  inertia: {value: 1.3e-5, unit: kg m^2, source: identified}",
            "  viscous: {value: 3.8e-4, unit: N m s/rad, source: identified}",
            "  coulomb: {value: 0.1, unit: N m, source: identified}",
            "  breakaway: {value: 0.15, unit: N m, source: identified}",
            "  offset: {value: 0, unit: N m, source: identified}",
            "provenance: {command: x, frictool: 0.1.0, inputs: []}",
            "",
        ]
    )
    (tmp_path / "model.yaml").write_text(document)
    result = run("compare", tmp_path / "model.yaml", "--law", "stribeck", "--json")
    assert result.code == 0, result.stderr
    view = json.loads(result.stdout)["laws"]["stribeck"]
    unit_of_time = 1.3e-5 / 3.8e-4 / 2.5
    assert view["stick_slip"]["period_s"] == pytest.approx(6.5123 * unit_of_time, rel=1e-4)
    assert view["limit_cycle"]["amplitude_rad"] == pytest.approx(
        0.0669 * 0.1 * unit_of_time**2 / 1.3e-5, rel=2e-3
    )
    (tmp_path / "smooth.yaml").write_text(
        document.replace("coulomb: {value: 0.1,", "coulomb: {value: 0,")
    )
    refused(
        run("compare", tmp_path / "smooth.yaml"), 3, "smooth.yaml", "parameters.coulomb: found 0"
    )


@pytest.mark.parametrize("content", [None, b"", b"\x00\xff\x89", b"format: nothing/1\n", b"- 1\n"])
def test_an_unusable_document_is_one_line_and_no_output(
    tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "friction.yaml"
    if content is not None:
        path.write_bytes(content)
    refused(run("compare", path, "-o", tmp_path / "out.html"), 3, str(path))
    assert not (tmp_path / "out.html").exists()


def test_a_misspelt_key_and_an_output_that_is_the_input(tmp_path: Path) -> None:
    path = tmp_path / "friction.yaml"
    path.write_text((MASS / "friction.yaml").read_text().replace("breakaway:", "breakawy:"))
    refused(run("compare", path), 3, "did you mean 'breakaway'?")
    path.write_text((MASS / "friction.yaml").read_text())
    refused(
        run("compare", path, "--law", "svc", "-o", also_called(path, ".html")), 3, "is an input"
    )


@pytest.mark.parametrize(
    ("printed", "found", "words"),
    [
        (
            "step_s: 4e-5",
            "step_s: 1e-12",
            "hybrid.step_s is 1e-12; allowed for these tests: 3e-07 to 0.1",
        ),
        ("step_s: 4e-5", "step_s: 1e3", "hybrid.step_s is 1000;"),
        (
            "presliding: {value: 1e-5,",
            "presliding: {value: 1e-15,",
            "presliding is 1e-15; allowed for these tests: 1e-07 to 1",
        ),
        ("preisach_intervals: 20", "preisach_intervals: 21", "found 21; allowed: an even number"),
        ("coulomb: {value: 1,", "coulomb: {value: -1,", "coulomb"),
    ],
)
def test_parameters_that_cannot_be_simulated_are_one_line(
    tmp_path: Path, printed: str, found: str, words: str
) -> None:
    text = (MASS / "friction.yaml").read_text()
    assert printed in text
    path = tmp_path / "friction.yaml"
    path.write_text(text.replace(printed, found))
    refused(run("compare", path, "--allow", "-o", tmp_path / "out.html"), 3, str(path), words)
    assert not (tmp_path / "out.html").exists()


@pytest.mark.parametrize(
    ("printed", "found", "words"),
    [
        (
            "inertia: {value: 1,",
            "inertia: {value: 1e300,",
            "the tests' time scale is 1e+300 s, their length scale inf",
        ),
        (
            "breakaway: {value: 1.5,",
            "breakaway: {value: 1e300,",
            "breakaway is 1e+300; allowed for these tests: 1 to 100",
        ),
        (
            "stribeck_velocity: {value: 1e-3",
            "stribeck_velocity: {value: 1e30",
            "stribeck_velocity is 1e+30",
        ),
        (
            "decay_rad_s: 1e3",
            "decay_rad_s: 1e300",
            "hybrid.decay_rad_s is 1e+300; allowed for these tests: 1 to 25000",
        ),
        (
            "format: friction/1",
            "format: bench/1",
            "format: found bench/1; allowed: friction/1, model/1",
        ),
    ],
)
def test_absurd_numbers_are_one_line(tmp_path: Path, printed: str, found: str, words: str) -> None:
    text = (MASS / "friction.yaml").read_text()
    assert printed in text
    path = tmp_path / "friction.yaml"
    path.write_text(text.replace(printed, found))
    refused(run("compare", path), 3, str(path), words)


def test_a_file_in_the_place_of_the_folder_is_refused_before_the_tests_are_run(
    tmp_path: Path,
) -> None:
    (tmp_path / "laws").write_text("kept")
    refused(run("compare", "-o", tmp_path / "laws"), 3, "laws: is a file")
    assert (tmp_path / "laws").read_text() == "kept"


def test_an_unknown_law_is_the_command_lines_fault() -> None:
    result = run("compare", "--law", "lugr")
    assert result.code == 2
    assert "Did you mean 'lugre'?" in result.stderr


def test_help_opens_with_an_example() -> None:
    lines = run("compare", "--help").stdout.splitlines()
    assert "Example:" in lines[2]
    assert "frictool compare" in lines[3]


EXTENDED = """
backward: {coulomb: {value: 0.9, unit: N}}
position: {over: {low: -1, high: 7, unit: m}, levels: {forward: [1, 0.02]}}
regimes: [{above: {value: 0.1, unit: m/s}, viscous: {value: 0.6, unit: N s/m}}]
dwell: {fresh: 0.8, rise_time_s: 0.5}
film: {lag_s: 1e-3}
"""


def test_what_laws_take_on_top_runs_where_it_makes_sense_and_is_one_line_where_not(
    tmp_path: Path,
) -> None:
    document = tmp_path / "extended.yaml"
    document.write_text((MASS / "friction.yaml").read_text() + EXTENDED)
    found = run("compare", document, "--law", "stribeck", "--json")
    assert found.code == 0, found.stderr
    law = json.loads(found.stdout)["laws"]["stribeck"]
    assert law["stick_slip"]["first_breakaway_s"] != pytest.approx(
        7.5, abs=0.05
    )  # the place and the rest raise the breakaway otherwise
    assert json.loads(found.stdout)["tables"]["2.1"]["stribeck"]["rising_static_friction"] == "+"
    refused(
        run("compare", document, "--law", "lugre"), 3, "extended.yaml", "lugre never rests", "--law"
    )
    document.write_text(
        (MASS / "friction.yaml").read_text() + EXTENDED.replace("[1, 0.02]", "[1, -0.5]")
    )
    refused(run("compare", document), 3, "extended.yaml", "mean")
