"""Example values of `frictool init` that nobody replaced: every command that reads them warns, and
every verdict repeats it."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.documents.starting_documents import StartingRig, example_keys, starting_documents
from frictool.documents.writing import to_yaml
from studies.command_line import run
from studies.rigs.campaign_rig import played
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import ROOT, clutch_spec
from studies.rigs.step_scenario import controller
from studies.rigs.verified_controller import truthful
from tests.support.short_logs import first_part

LEFT = "example values of `frictool init` are not replaced yet"
LOG = ROOT / "sample_logs/ramp.csv"


@pytest.mark.parametrize(
    "start",
    [
        StartingRig("rig", "rotary"),
        StartingRig("rig", "linear", axis_source="example"),
        StartingRig("rig", "rotary", period=1e-3, step=0.1),
    ],
)
def test_each_document_lists_the_keys_that_its_comments_mark(
    start: StartingRig, tmp_path: Path
) -> None:
    for name, text in starting_documents(start).items():
        if name == "Makefile":
            continue
        (tmp_path / "document.yaml").write_text(text)
        assert list(load(tmp_path / "document.yaml").examples) == example_keys(start).get(name, [])


def test_a_command_that_reads_a_bench_of_examples_names_them_until_they_are_replaced(
    tmp_path: Path,
) -> None:
    assert run("init", tmp_path / "rig", "--from", LOG, "--axis", "rotary").code == 0
    bench = tmp_path / "rig/bench.yaml"
    keys = load(bench, Bench).examples
    assert "mechanics.inertia" in keys
    for command in (
        ["info", LOG, "--bench", bench],
        ["ingest", LOG, "--bench", bench, "-o", tmp_path / "log.mcap"],
    ):
        done = run(*command)
        assert done.code == 0
        assert done.stderr.count(LEFT) == 1
        (line,) = (one for one in done.stderr.splitlines() if LEFT in one)
        shown = [key for key in keys if key in line]
        assert len(shown) > 2
        assert line.endswith(f" and {len(keys) - len(shown)} more")
        assert LEFT not in done.stdout
    text = bench.read_text()
    for key in keys[1:]:
        text = text.replace(f"  - {key}\n", "")
    bench.write_text(text)
    assert f"{LEFT}: {bench}: {keys[0]}\n" in run("info", LOG, "--bench", bench).stderr
    bench.write_text(text.replace(f"  - {keys[0]}\n", "").replace("examples:", "# examples:"))
    assert LEFT not in run("info", LOG, "--bench", bench).stderr


def test_what_a_model_copies_of_its_bench_carries_the_examples(tmp_path: Path) -> None:
    assert run("init", tmp_path / "rig", "--from", LOG, "--axis", "rotary").code == 0
    bench = tmp_path / "rig/bench.yaml"
    model, sines = tmp_path / "model.yaml", tmp_path / "sines.csv"
    sines.write_text(first_part("sines.csv"))
    done = run("identify", sines, "--bench", bench, "-o", model)
    assert done.code == 0, done.stderr
    assert load(model).bench.examples == load(bench, Bench).examples
    assert (
        "bench.actuator.limit and 6 more"
        in run(
            "observe", "design", model, "--kind", "tracking", "-o", tmp_path / "observer.yaml"
        ).stderr
    )


class Rig:
    """Documents with examples that are not replaced."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        model, loop = clutch_model(), truthful(controller())
        bench = msgspec.structs.replace(
            model.bench, examples=("mechanics.inertia", "actuator.limit")
        )
        spec = clutch_spec(
            rest=None,
            overshoot_percent=1e4,
            static_error=None,
            oscillations=None,
            response_time_95_s=0.55,
        )
        documents = {
            "model": msgspec.structs.replace(model, bench=bench),
            "controller": msgspec.structs.replace(
                loop, bench=msgspec.structs.replace(loop.bench, examples=bench.examples)
            ),
            "scenario": msgspec.structs.replace(played(), examples=("steps",)),
            "spec": msgspec.structs.replace(spec, examples=("modulus_margin",)),
        }
        for name, document in documents.items():
            (folder / f"{name}.yaml").write_text(to_yaml(document))

    def __getattr__(self, name: str) -> Path:
        return self.folder / f"{name}.yaml"


def test_every_output_of_a_verdict_repeats_them(tmp_path: Path) -> None:
    rig, log = Rig(tmp_path), tmp_path / "run.mcap"
    done = run(
        "simulate", rig.model, "--controller", rig.controller, "--scenario", rig.scenario, "-o", log
    )
    assert done.code == 0, done.stderr
    assert (
        done.stderr.count(LEFT) == 2
    )  # the model's bench, which the controller has too, and the scenario
    told = (
        f"{LEFT}: spec: modulus_margin; bench: mechanics.inertia, actuator.limit; scenario: steps"
    )
    page, suite, table = (tmp_path / f"report.{kind}" for kind in ("html", "xml", "md"))
    words = ("report", log, "--spec", rig.spec, "--controller", rig.controller)
    shown = run(*words, "-o", page, "--junit", suite, "--markdown", table)
    assert f"warning: {told}\n" in shown.stdout
    assert json.loads(run(*words, "--json").stdout)["warnings"] == [told]
    assert told in page.read_text()
    assert told in table.read_text().replace("\\", "")
    assert told in [one.get("value") for one in ET.parse(suite).getroot().iter("property")]
    found = run(
        "campaign",
        rig.model,
        rig.controller,
        "--scenario",
        rig.scenario,
        "--spec",
        rig.spec,
        "-n",
        "3",
        "--cores",
        "1",
        "-o",
        page,
        "--json",
    )
    assert told in json.loads(found.stdout)["warnings"]
    assert told in page.read_text()


def test_documents_without_examples_are_read_without_a_word(tmp_path: Path) -> None:
    done = run("info", LOG, "--bench", ROOT / "configs/clutch/bench.yaml")
    assert (done.code, done.stderr) == (0, "")
