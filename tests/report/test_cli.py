"""`frictool report` as a shell sees it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.spec import Spec
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log
from studies.command_line import run
from studies.rigs.step_logs import (
    ENCODER_STEP,
    ROOT,
    clutch_log,
    clutch_spec,
    controller,
    smooth_log,
    stream,
)
from studies.rigs.verified_controller import truthful
from tests.support.command_line import also_called, refused


class Rig:
    """Files in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.spec = self.document("spec.yaml", clutch_spec())
        self.controller = self.document("controller.yaml", truthful(controller()))
        self.log = self.record("run.mcap", clutch_log(1))

    def document(self, name: str, document: msgspec.Struct) -> Path:
        path = self.folder / name
        path.write_text(to_yaml(document))
        return path

    def record(self, name: str, log: Log) -> Path:
        path = self.folder / name
        with path.open("wb") as target:
            write_mcap(log, target)
        return path


@pytest.fixture(name="rig")
def _rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path)


def test_all_outputs_at_once(rig: Rig) -> None:
    page, suite, table = (rig.folder / f"report.{kind}" for kind in ("html", "xml", "md"))
    result = run(
        "report",
        rig.log,
        "--spec",
        rig.spec,
        "--controller",
        rig.controller,
        "-o",
        page,
        "--junit",
        suite,
        "--markdown",
        table,
        "--json",
    )
    assert result.code == 0, result.stderr
    view = json.loads(result.stdout)
    assert view["verdict"] == "pass"
    assert len(view["requirements"]) == 7
    assert all(r["met"] for r in view["requirements"])
    assert [s["stream"] for s in view["streams"]] == ["/axis", "/axis/v00"]
    html = page.read_text()
    assert "PASS: 7 of 7 requirements met" in html
    assert view["sensitivity"]["gamma_is"] == "asked"
    assert html.count('at every vertex"') == 4
    assert str(rig.folder) not in html
    assert "frictool report run.mcap --spec spec.yaml --controller controller.yaml" in html
    assert ET.parse(suite).getroot().get("tests") == "7"
    assert table.read_text().startswith("### clutch: PASS")


def test_of_vertices_that_agree_the_first_is_named_whatever_rounding_says(rig: Rig) -> None:
    """v00, v01 and v02 are one plant here, so that they have one margin; each in turn is made the
    smallest in its tenth digit."""
    honest = truthful(controller())
    for lowest in range(3):
        vertices = [
            msgspec.structs.replace(
                one, modulus_margin=one.modulus_margin * (1.0 - 1e-9 * (index == lowest))
            )
            for index, one in enumerate(honest.verified.vertices)
        ]
        verified = msgspec.structs.replace(honest.verified, vertices=tuple(vertices))
        path = rig.document("rounded.yaml", msgspec.structs.replace(honest, verified=verified))
        result = run("report", rig.log, "--spec", rig.spec, "--controller", path, "--json")
        margin = next(
            one
            for one in json.loads(result.stdout)["requirements"]
            if one["name"] == "modulus_margin"
        )
        assert margin["where"]["vertex"] == "v00"


def test_what_is_not_met_is_exit_1_and_the_page_is_written(rig: Rig) -> None:
    log = rig.record("soft.mcap", Log((stream(damping=0.4),), {}, "soft"))
    page = rig.folder / "report.html"
    result = run("report", log, "--spec", rig.spec, "-o", page)
    assert result.code == 1
    assert result.stderr == ""
    assert "NOT MET     overshoot" in result.stdout
    assert "UNDECIDED   modulus margin" in result.stdout
    assert "NOT MET" in page.read_text()


def test_the_same_inputs_give_the_same_files(rig: Rig) -> None:
    first, second = rig.folder / "a.html", rig.folder / "b.html"
    for page in (first, second):
        assert (
            run(
                "report", rig.log, "--spec", rig.spec, "--controller", rig.controller, "-o", page
            ).code
            == 0
        )
    assert first.read_bytes() == second.read_bytes()


def test_the_page_on_stdout_leaves_the_text_to_stderr(rig: Rig) -> None:
    result = run("report", rig.log, "--spec", rig.spec, "-o", "-")
    assert result.stdout.startswith("<!DOCTYPE html>")
    assert result.stdout.rstrip().endswith("</html>")
    assert "UNDECIDED: 6 of 7 requirements met, 1 undecided" in result.stderr


def test_json_alone_writes_nothing(rig: Rig) -> None:
    before = sorted(rig.folder.iterdir())
    result = run("report", rig.log, "--spec", rig.spec, "--json")
    assert json.loads(result.stdout)["undecided"] == ["modulus_margin"]
    assert sorted(rig.folder.iterdir()) == before


def test_json_alone_does_not_load_the_plotting(rig: Rig) -> None:
    code = (
        "import sys\nfrom frictool.cli.main import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print([name for name in ('matplotlib', 'numba', 'jinja2', 'cvxpy') if name in "
        "sys.modules], file=sys.stderr)"
    )
    words = [sys.executable, "-c", code, "report", str(rig.log), "--spec", str(rig.spec), "--json"]
    done = subprocess.run([*words, "--allow-undecided"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["verdict"] == "undecided"
    assert done.stderr.strip() == "[]"


def test_a_smooth_reference_is_reported_with_reasons(rig: Rig) -> None:
    log = rig.record("sines.mcap", smooth_log())
    result = run("report", log, "--spec", rig.spec, "--json")
    view = json.loads(result.stdout)
    assert result.code == 1
    assert view["verdict"] == "undecided"
    assert {r["name"] for r in view["requirements"] if r["met"] is None} == set(view["undecided"])
    assert len(view["undecided"]) == 6
    assert all(r["reason"] for r in view["requirements"] if r["met"] is None)


def test_one_undecided_requirement_is_exit_1_in_every_output_unless_it_is_allowed(rig: Rig) -> None:
    suite, table, page = (rig.folder / f"report.{kind}" for kind in ("xml", "md", "html"))
    words = ("report", rig.log, "--spec", rig.spec, "--junit", suite)
    result = run(*words, "--markdown", table, "-o", page)
    assert result.code == 1
    headline = "UNDECIDED: 6 of 7 requirements met, 1 undecided, on 2 recorded streams"
    assert result.stdout.splitlines()[-1] == headline
    assert table.read_text().startswith(f"### clutch: {headline}")
    assert f'<p class="banner open">{headline}</p>' in page.read_text()
    root = ET.parse(suite).getroot()
    assert (root.get("errors"), root.get("skipped")) == ("1", "0")
    assert {p.get("name"): p.get("value") for p in root.iter("property")} == {
        "verdict": "undecided",
        "summary": headline,
    }
    assert json.loads(run(*words, "--json").stdout)["verdict"] == "undecided"
    allowed = run(*words, "--allow-undecided")
    assert allowed.code == 0
    assert allowed.stdout == result.stdout
    root = ET.parse(suite).getroot()
    assert (root.get("errors"), root.get("skipped")) == ("0", "1")


def test_what_is_broken_stays_exit_1_with_undecided_allowed(rig: Rig) -> None:
    log = rig.record("soft.mcap", Log((stream(damping=0.4),), {}, "soft"))
    suite = rig.folder / "report.xml"
    result = run("report", log, "--spec", rig.spec, "--junit", suite, "--allow-undecided")
    assert result.code == 1
    assert result.stdout.splitlines()[-1].startswith("FAIL: ")
    root = ET.parse(suite).getroot()
    assert (root.get("errors"), root.get("skipped")) == ("1", "0")
    assert root.get("failures") == str(result.stdout.count("NOT MET")) != "0"


@pytest.mark.parametrize("options", [(), ("--allow-undecided",)])
def test_nothing_to_decide_is_exit_1(rig: Rig, options: tuple[str, ...]) -> None:
    log = rig.record("sines.mcap", smooth_log())
    spec = rig.document("steps_only.yaml", clutch_spec(drive_peak=None))
    result = run("report", log, "--spec", spec, *options)
    assert result.code == 1
    assert result.stdout.endswith("UNDECIDED: the logs decide none of the requirements\n")


def test_the_measured_record_is_reported_on_with_the_same_command(tmp_path: Path) -> None:
    """Its reference is smooth: the drive is judged, the rest says why it is not."""
    data = Path(os.environ.get("FRICTOOL_DATA", ROOT / "../shared/data")) / "emps/DATA_EMPS.mat"
    if not data.exists():
        pytest.skip(
            "the EMPS record is not here; set FRICTOOL_DATA to the folder that holds "
            "emps/DATA_EMPS.mat"
        )
    page = tmp_path / "emps.html"
    result = run(
        "report",
        data,
        "--spec",
        ROOT / "configs/emps/spec.yaml",
        "--bench",
        ROOT / "configs/emps/bench.yaml",
        "-o",
        page,
        "--json",
    )
    assert result.code == 1, result.stderr
    view = json.loads(result.stdout)
    assert view["undecided"] == ["response_time_95", "overshoot", "static_error", "modulus_margin"]
    assert next(
        r["value"] for r in view["requirements"] if r["name"] == "drive_peak"
    ) == pytest.approx(4.3, abs=0.05)
    (only,) = view["streams"]
    assert only["encoder_step"] == pytest.approx(5e-8, rel=1e-3)
    assert only["tracking_error_peak"] == pytest.approx(0.85e-3, abs=0.05e-3)
    assert 0.0 < only["drive_rms"] < only["drive_peak"]
    assert (only["saturation_time"], only["holds"]) == (0.0, [])
    html = page.read_text()
    assert html.count(">UNDECIDED<") == 4
    for picture in ("position", "error", "voltage", "velocity"):
        assert f'aria-label="{picture} over ' in html
    assert page.stat().st_size < 500_000


@pytest.mark.parametrize("damage", ["missing", "empty", "binary", "truncated", "directory"])
def test_a_bad_log_is_one_line_and_no_output(rig: Rig, damage: str) -> None:
    log = rig.folder / "bad.mcap"
    if damage == "directory":
        log.mkdir()
    elif damage != "missing":
        log.write_bytes(
            {"empty": b"", "binary": bytes(range(256)), "truncated": rig.log.read_bytes()[:1000]}[
                damage
            ]
        )
    page, suite = rig.folder / "report.html", rig.folder / "report.xml"
    refused(
        run("report", rig.log, log, "--spec", rig.spec, "-o", page, "--junit", suite), 3, "bad.mcap"
    )
    assert not page.exists()
    assert not suite.exists()


def test_a_raw_log_is_read_by_the_bench(rig: Rig) -> None:
    raw = rig.folder / "steps.csv"
    nominal = clutch_log().streams[0]
    counts = np.rint(nominal.signals["position"] / ENCODER_STEP).astype(int)
    rows = zip(nominal.time[:3000], counts, nominal.signals["current"], strict=False)
    raw.write_text(
        "time [s],encoder [count],current [A]\n"
        + "".join(f"{t:.3f},{c},{i:.4f}\n" for t, c, i in rows)
    )
    refused(run("report", raw, "--spec", rig.spec, "--json"), 3, "steps.csv", "--bench")
    for option, document in (
        ("--bench", ROOT / "configs/clutch/bench.yaml"),
        ("--controller", rig.controller),
    ):
        result = run(
            "report", raw, "--spec", rig.spec, option, document, "--json", "--allow-undecided"
        )
        assert result.code == 0, result.stderr
        by_name = {r["name"]: r for r in json.loads(result.stdout)["requirements"]}
        assert by_name["overshoot"]["reason"] == "steps.csv /axis: the log has no reference"
        assert by_name["drive_peak"]["value"] == pytest.approx(50.0, abs=0.5)


def test_a_misspelt_requirement_is_refused_with_the_nearest(rig: Rig) -> None:
    rig.spec.write_text(rig.spec.read_text().replace("overshoot_percent", "overshot_percent"))
    refused(
        run("report", rig.log, "--spec", rig.spec, "--json"),
        3,
        "spec.yaml:",
        "overshot_percent",
        "did you mean 'overshoot_percent'?",
    )


def test_a_specification_that_asks_for_nothing_is_refused(rig: Rig) -> None:
    spec = rig.document(
        "nothing.yaml", Spec(format="spec/1", name="nothing", axis="rotary", drive="current")
    )
    refused(
        run("report", rig.log, "--spec", spec, "--json"),
        3,
        "nothing.yaml",
        "has no requirement",
        "overshoot_percent",
    )


def test_documents_of_two_kinds_of_axis_are_refused(rig: Rig) -> None:
    other = msgspec.structs.replace(clutch_spec(static_error=None), axis="linear")
    spec = rig.document("linear.yaml", other)
    refused(
        run("report", rig.log, "--spec", spec, "--controller", rig.controller, "--json"), 3, "axis"
    )
    refused(run("report", rig.log, "--spec", spec, "--json"), 3, "position of /axis is in rad")


def test_an_input_is_never_overwritten(rig: Rig) -> None:
    before = rig.log.read_bytes()
    refused(
        run(
            "report",
            rig.log,
            "--spec",
            rig.spec,
            "--markdown",
            rig.folder / "x.md",
            "-o",
            also_called(rig.log, ".html"),
        ),
        3,
        "is an input",
    )
    assert rig.log.read_bytes() == before
    assert not (rig.folder / "x.md").exists()


def test_two_outputs_of_one_name_are_a_wrong_command_line(rig: Rig) -> None:
    result = run(
        "report", rig.log, "--spec", rig.spec, "-o", rig.folder / "x", "--junit", rig.folder / "x"
    )
    assert result.code == 2
    assert "-o and --junit have the same name" in result.stderr


def test_help_opens_with_an_example() -> None:
    result = run("report", "--help")
    assert result.code == 0
    example = result.stdout.split("Example:")[1].splitlines()[1]
    assert (
        example.strip()
        == "frictool report run.mcap --spec spec.yaml --controller controller.yaml -o report.html"
    )
