"""The recipe "A requirement" of CONTRIBUTING.md, followed with a dummy of a hold and of a stream."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log
from studies.rigs.step_logs import ROOT, stream
from tests.docs.recipe import CopiedPackage

FUNCTIONS = '''"""Distance of the position from the reference."""

import numpy as np

from frictool.typing import Vector


def furthest(position: Vector, target: float) -> float:
    """Return the largest distance from the target [rad or m]."""
    return float(np.max(np.abs(position - target)))


def busiest(time: Vector, drive: Vector) -> float | str:
    """Return the largest change of the drive between two samples [A | V], or a reason."""
    return float(np.max(np.abs(np.diff(drive)))) if time.size > 1 else "there is one sample only"
'''
RECORDS = """    Metric(
        "dummy_distance",
        "distance of the dummy",
        "position",
        "what the dummy measures of a hold",
        compute="dummy.furthest",
        needs=("step",),
        key="dummy_distance",
        limit=PositiveLength,
        meaning="Limit of the dummy of a hold.",
    ),
    Metric(
        "dummy_change",
        "change of the dummy",
        "drive",
        "what the dummy measures of a stream",
        scope="stream",
        compute="dummy.busiest",
        needs=("drive",),
        key="dummy_change",
        limit=DriveLimit,
        meaning="Limit of the dummy of a stream.",
    ),
"""
KEYS = "dummy_distance: {value: 40, unit: rad}\ndummy_change: {value: 1, unit: mA}\n"
SCENARIO = """format: scenario/1
name: short
axis: linear
start: {value: 0, unit: m}
steps:
  - {reference: {value: 1, unit: m}, duration_s: 2}
spread: {start: {low: -0.1, high: 0.1, unit: m}}
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> CopiedPackage:
    copy = CopiedPackage.into(tmp_path_factory.mktemp("metric"))
    (copy.folder / "frictool/metrics/dummy.py").write_text(FUNCTIONS)
    copy.insert("frictool/documents/metric_table.py", ")", RECORDS)
    return copy


def test_the_schema_has_the_keys_with_their_definitions(package: CopiedPackage) -> None:
    spec = json.loads(package.run("schema", "spec").stdout)["$defs"]["Spec"]
    described = [
        spec["properties"][f"dummy_{name}"]["description"] for name in ("distance", "change")
    ]
    assert described == ["Limit of the dummy of a hold.", "Limit of the dummy of a stream."]


def test_each_view_of_a_verdict_has_the_metrics(package: CopiedPackage, tmp_path: Path) -> None:
    spec, log = tmp_path / "spec.yaml", tmp_path / "run.mcap"
    base = (ROOT / "configs/clutch/spec.yaml").read_text().replace("modulus_margin", "# no ")
    spec.write_text(base + KEYS)
    axis = stream()
    with log.open("wb") as target:
        write_mcap(Log((axis,), {}, "run.mcap"), target)
    page, suite, table = (tmp_path / f"report.{ending}" for ending in ("html", "xml", "md"))
    outputs = ["-o", page, "--junit", suite, "--markdown", table]
    result = package.run("report", log, "--spec", spec, *outputs, "--json", code=1)
    view = json.loads(result.stdout)
    (only,) = view["streams"]
    hold = only["holds"][0]
    held = axis.signals["position"][axis.signals["reference"] == hold["to"]]
    change = float(np.max(np.abs(np.diff(axis.signals["current"]))))
    assert hold["dummy_distance"] == pytest.approx(float(np.max(np.abs(held - hold["to"]))))
    assert only["dummy_change"] == pytest.approx(change)
    assert (view["units"]["dummy_distance"], view["units"]["dummy_change"]) == ("rad", "A")
    judged = {one["key"]: one for one in view["requirements"]}
    assert list(judged)[-2:] == ["dummy_distance", "dummy_change"]
    assert (judged["dummy_distance"]["met"], judged["dummy_distance"]["limit"]) == (False, 40.0)
    assert (judged["dummy_change"]["met"], judged["dummy_change"]["limit"]) == (False, 0.001)
    names = [case.get("name") for case in ET.parse(suite).getroot().iter("testcase")]
    assert names[-2:] == ["dummy_distance", "dummy_change"]
    assert "| dummy distance |" in table.read_text()
    text = page.read_text()
    assert "distance of the dummy [rad]" in text
    assert "<dt>distance of the dummy</dt><dd>what the dummy measures of a hold</dd>" in text
    assert "change of the dummy [A]" in text


def test_a_metric_without_a_value_has_its_reason(package: CopiedPackage, tmp_path: Path) -> None:
    spec = tmp_path / "spec.yaml"
    head = "format: spec/1\nname: dummy\naxis: rotary\ndrive: current\n"
    spec.write_text(head + KEYS)
    log = ROOT / "sample_logs/sines.csv"
    bench = ROOT / "configs/clutch/bench.yaml"
    result = package.run("report", log, "--spec", spec, "--bench", bench, "--json", code=1)
    judged = {one["key"]: one for one in json.loads(result.stdout)["requirements"]}
    assert judged["dummy_distance"]["met"] is None
    assert "the log has no " in judged["dummy_distance"]["reason"]
    assert judged["dummy_change"]["met"] is False


def test_a_campaign_has_a_column_of_each(package: CopiedPackage, tmp_path: Path) -> None:
    scenario, spec, controller = (tmp_path / f"{name}.yaml" for name in ("steps", "spec", "loop"))
    scenario.write_text(SCENARIO)
    keys = KEYS.replace("40, unit: rad", "2, unit: m")
    spec.write_text("format: spec/1\nname: dummy\naxis: linear\ndrive: current\n" + keys)
    rig, table = ROOT / "configs/mass", tmp_path / "trials.csv"
    model = rig / "model.yaml"
    design = [model, "--spec", rig / "spec.yaml", "--design", rig / "designs/pid.yaml"]
    package.run("synth", *design, "--vertices-only", "-o", controller)
    documents = [model, controller, "--scenario", scenario, "--spec", spec]
    package.run("campaign", *documents, "-n", "2", "--cores", "1", "--table", table, code=1)
    header, *trials = table.read_text().splitlines()
    assert {"dummy_distance [m]", "dummy_change [A]"} <= set(header.split(","))
    assert len(trials) == 2
