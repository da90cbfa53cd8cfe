"""`frictool init --example`: worked rigs whose documents load, whose logs identify the simulated
parameters, and whose copies agree with configs/."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from frictool.documents.bench import Bench
from frictool.documents.example_rigs import EXAMPLES
from frictool.documents.model import Model
from frictool.documents.registry import load
from studies.command_line import run
from studies.rigs.clutch_model import ROOT
from studies.rigs.example_rigs import DOCUMENTS, TRUTH
from studies.rigs.sample_logs import TRUTH as CLUTCH
from tests.support.command_line import refused

SMALL = 1_600_000  # bytes of all packed logs


def truth(name: str) -> dict[str, float]:
    if name == "clutch":
        return {"inertia": CLUTCH.inertia, "viscous": CLUTCH.viscous, "coulomb": CLUTCH.coulomb}
    if name == "emps":
        parameters = load(ROOT / "configs/emps/published.yaml", Model).parameters
        return {key: getattr(parameters, key).value for key in ("inertia", "viscous", "coulomb")}
    found = yaml.safe_load(TRUTH)["parameters"]
    return {key: found[key]["value"] for key in ("inertia", "viscous", "coulomb")}


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=pytest.mark.accept) if one != "joint" else one for one in EXAMPLES],
)
def test_the_logs_of_an_example_identify_what_was_simulated(name: str, tmp_path: Path) -> None:
    folder = tmp_path / name
    result = run("init", folder, "--example", name, "--json")
    assert result.code == 0
    files = json.loads(result.stdout)["files"]
    assert {"bench.yaml", "spec.yaml", "Makefile", "logs/sines.csv", "logs/ramp.csv"} <= {*files}
    bench = load(folder / "bench.yaml", Bench)
    assert bench.examples == ()
    logs = []
    for log in ("sines", "ramp"):
        logs.append(folder / f"{log}.mcap")
        source = folder / f"logs/{log}.csv"
        assert run("ingest", source, "--bench", folder / "bench.yaml", "-o", logs[-1]).code == 0
    model = folder / "model.yaml"
    result = run("identify", *logs, "--bench", folder / "bench.yaml", "-o", model)
    assert result.code == 0, result.stderr
    parameters = load(model, Model).parameters
    for key, value in truth(name).items():
        low, high = getattr(parameters, key).interval
        assert low <= value <= high, key
        known = getattr(bench.mechanics, key)  # less than this is told by the bench alone
        assert high - low < known.high - known.low, key
    for document in ("spec.yaml", "scenarios/steps.yaml", *(f for f in files if "designs/" in f)):
        assert load(folder / document).axis == bench.axis


def test_an_example_overwrites_nothing_and_takes_no_other_facts(tmp_path: Path) -> None:
    (tmp_path / "spec.yaml").write_text("mine")
    refused(run("init", tmp_path, "--example", "joint"), 3, "spec.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["spec.yaml"]
    result = run("init", tmp_path / "new", "--example", "joint", "--axis", "linear")
    assert (result.code, "--example does not work with --axis" in result.stderr) == (2, True)


@pytest.mark.parametrize("name", ["clutch", "emps"])
def test_the_packaged_documents_are_those_of_configs(name: str) -> None:
    packaged = ROOT / "frictool/documents/examples" / name
    for document in DOCUMENTS:
        assert (packaged / document).read_bytes() == (
            ROOT / "configs" / name / document
        ).read_bytes()


def test_the_packed_logs_are_small() -> None:
    packed = (ROOT / "frictool/documents/examples").rglob("*.xz")
    assert sum(path.stat().st_size for path in packed) < SMALL
