"""A requirement that is added by the recipe alone is known to documents, report and campaign."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log
from studies.rigs.step_logs import stream
from tests.support.documentation_pages import ROOT
from tests.support.recipes import follow, frictool

DEFINITION = "time from the step until the position has moved by more than one sensor step"
SPEC = "format: spec/1\nname: tried\naxis: {}\ndrive: current\ndead_time: {{value: 1, unit: ms}}\n"
SCENARIO = """\
format: scenario/1
name: short
axis: linear
start: {value: 0, unit: m}
steps:
  - {reference: {value: 1, unit: m}, duration_s: 2}
spread: {start: {low: -0.1, high: 0.1, unit: m}}
"""


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("requirement")
    follow("A requirement", folder)
    (folder / "spec.yaml").write_text(SPEC.format("rotary"))
    return folder


def test_the_schema_has_the_key_with_its_meaning(overlay: Path) -> None:
    spec = json.loads(frictool(overlay, "schema", "spec").stdout)["$defs"]["Spec"]
    key = spec["properties"]["dead_time"]
    assert key["description"] == "Largest time from a step of the reference until the axis moves."
    wrong = overlay / "wrong.yaml"
    wrong.write_text(SPEC.format("rotary").replace("value: 1", "value: -1"))
    refused = frictool(overlay, "report", ROOT / "sample_logs/sines.csv", "--spec", wrong)
    assert refused.returncode == 3
    assert "wrong.yaml:5: dead_time.value: found -1 ms; allowed: > 0" in refused.stderr


def test_each_view_of_a_verdict_has_the_metric(overlay: Path) -> None:
    axis, log = stream(), overlay / "run.mcap"
    with log.open("wb") as target:
        write_mcap(Log((axis,), {}, "run.mcap"), target)
    page, suite, table = (overlay / f"report.{ending}" for ending in ("html", "xml", "md"))
    outputs = ["-o", page, "--junit", suite, "--markdown", table, "--json"]
    done = frictool(overlay, "report", log, "--spec", overlay / "spec.yaml", *outputs)
    assert done.returncode == 1, done.stderr
    view = json.loads(done.stdout)
    times = [hold["dead_time"] for hold in view["streams"][0]["holds"]]
    assert times == [
        pytest.approx(_moves(axis.time, axis.signals["position"], hold))
        for hold in view["streams"][0]["holds"]
    ]
    assert view["units"]["dead_time"] == "s"
    (judged,) = view["requirements"]
    assert (judged["name"], judged["key"], judged["limit"]) == ("dead_time", "dead_time", 0.001)
    assert (judged["met"], judged["value"]) == (False, max(times))
    assert [case.get("name") for case in ET.parse(suite).getroot().iter("testcase")] == [
        "dead_time"
    ]
    assert f"| first motion | {max(times):.4g} s | ≤ 0.001 s |" in table.read_text()
    text = page.read_text()
    assert f"<dt>first motion</dt><dd>{DEFINITION}</dd>" in text
    assert "first motion [s]" in text
    assert re.search(r"<strong>(<a [^>]*>)?first motion<", text)
    told = frictool(overlay, "report", log, "--spec", overlay / "spec.yaml").stdout
    assert f"NOT MET     first motion      {max(times):.4g} s" in told


def _moves(time: np.ndarray, position: np.ndarray, hold: dict[str, float]) -> float:
    """Time from the start of a hold until the position first changes by more than one count."""
    count = 2.0 * np.pi / 56.0
    start = int(np.searchsorted(time, hold["start_s"] - 1e-9))
    for sample in range(start, time.size):
        if abs(position[sample] - position[start]) > 1.5 * count:
            return float(time[sample] - time[start])
    raise AssertionError("the axis does not move")


def test_a_hold_without_a_value_has_its_reason(overlay: Path) -> None:
    log, bench = ROOT / "sample_logs/sines.csv", ROOT / "configs/clutch/bench.yaml"
    spec = overlay / "spec.yaml"
    done = frictool(overlay, "report", log, "--spec", spec, "--bench", bench, "--json")
    assert done.returncode == 1, done.stderr
    (judged,) = json.loads(done.stdout)["requirements"]
    assert judged["met"] is None
    assert "the log has no reference" in judged["reason"]


@pytest.mark.accept
def test_a_campaign_has_its_column(overlay: Path) -> None:
    spec, scenario, table = (overlay / name for name in ("mass.yaml", "steps.yaml", "trials.csv"))
    spec.write_text(SPEC.format("linear"))
    scenario.write_text(SCENARIO)
    rig, controller = ROOT / "configs/mass", overlay / "controller.yaml"
    model = rig / "model.yaml"
    design = [
        "--spec",
        rig / "spec.yaml",
        "--design",
        rig / "designs/pid.yaml",
        "--vertices-only",
        "--no-play",
    ]
    made = frictool(overlay, "synth", model, *design, "-o", controller)
    assert made.returncode == 0, made.stderr
    documents = [model, controller, "--scenario", scenario, "--spec", spec]
    done = frictool(overlay, "campaign", *documents, "-n", "2", "--cores", "1", "--table", table)
    assert done.returncode == 0, done.stderr
    assert "\nfirst motion  " in done.stdout
    header, *trials = table.read_text().splitlines()
    assert "dead_time [s]" in header.split(",")
    assert len(trials) == 2
