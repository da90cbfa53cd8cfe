"""`frictool synth` without a design: from a specification to a controller, and its refusals."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from frictool.campaign import design_trial
from frictool.campaign.automatic_design import FAMILIES, _kept_blocks, _with_blocks
from frictool.campaign.trials.controller_judge import ControllerJudge
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.design_blocks import FeedforwardDesign, PrefilterDesign, ProfileDesign
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.weights import Weights
from frictool.errors import EXIT_INTERRUPTED
from frictool.synth.search.design_scales import design_scales
from frictool.synth.search.pi_cascade import PI_CASCADE
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.command_line import refused

FEW = 3  # candidates; the search itself is not the subject
RIG = ROOT / "configs/clutch"
EASY = """\
format: spec/1
name: easy
axis: rotary
drive: current
response_time_95_s: 0.35
overshoot_percent: 10
static_error: {value: 2.5, unit: rad}
modulus_margin: 0.5
drive_peak: {value: 50, unit: A}
rest: {after_s: 2, drive: 0}
"""


@pytest.fixture(autouse=True)
def few_plants(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw 8 plants besides the 33 of the vertices; the README shows a search on all 73."""
    monkeypatch.setattr(design_trial, "DRAWN", 8)
    monkeypatch.setattr(design_trial, "OTHERS", 4)


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "spec.yaml"
    path.write_text(EASY)
    return path


def _synth(spec: Path, *options: object) -> list[object]:
    return ["synth", RIG / "nonlinear.yaml", "--spec", spec, "--vertices-only", *options]


def test_a_specification_is_enough(
    spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = (replace(PI_CASCADE, candidates=FEW),)
    monkeypatch.setattr("frictool.campaign.automatic_design.FAMILIES", few)
    controller, design = tmp_path / "controller.yaml", tmp_path / "controller.design.yaml"
    done = run(*_synth(spec, "-o", controller))
    assert done.code == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("designed: PI cascade, ")
    assert lines[0].endswith(" with a reserve of 5 % (none for oscillations, drive and rest)")
    assert lines[1] == f"design file: {design}"
    plants = "on 41 plants, with steps of 20.16 to 50.4 rad"
    assert lines[-1] == f"PASS: 6 of 6 requirements met, {plants}"

    # the design gives the same controller, and every value of it has a comment
    again = tmp_path / "again.yaml"
    assert run(*_synth(spec, "--design", design, "--no-play", "-o", again)).code == 0
    found, provided = load(controller, Controller), load(again, Controller)
    assert found.linear == provided.linear
    assert found.position_law == provided.position_law
    assert found.prefilter == provided.prefilter
    values = [
        line
        for line in design.read_text().splitlines()
        if line.startswith("  ") and not line.endswith(":")
    ]
    assert len(values) >= 10
    assert all("  # " in line for line in values)
    assert load(design, Design).method == "pid"


@pytest.mark.accept
def test_the_same_specification_gives_the_same_bytes(spec: Path, tmp_path: Path) -> None:
    first, second = (
        (tmp_path / f"{name}.yaml", tmp_path / f"{name}.design") for name in ("one", "two")
    )
    for controller, design in (first, second):
        assert run(*_synth(spec, "-o", controller, "--save-design", design)).code == 0
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_a_requirement_that_no_candidate_reaches_is_named_with_the_trade(
    spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = (replace(PI_CASCADE, candidates=FEW),)
    monkeypatch.setattr("frictool.campaign.automatic_design.FAMILIES", few)
    spec.write_text(EASY.replace("_95_s: 0.35", "_95_s: 0.115"))
    controller, picture = tmp_path / "controller.yaml", tmp_path / "trade.svg"
    done = run(*_synth(spec, "-o", controller, "--plot", picture, "--json"))
    assert done.code == 4
    assert "error: no design found: " in done.stderr
    assert "for the best candidate, specified " in done.stderr
    assert not controller.exists()
    assert picture.read_text().startswith("<svg")
    told = json.loads(done.stdout)
    assert told["format"] == "synth-refusal/1"
    assert told["reason"] in done.stderr
    assert told["details"][0] == "searched: PI cascade, 5 candidates"
    assert told["details"][1].startswith("bound: at the drive's limit, a step of ")
    assert told["details"][2] == "best candidate, on 41 of 41 plants:"
    (response,) = (one for one in told["details"] if one.startswith("  response 95 % "))
    where = re.search(
        r"\(specified <= 0.115 s\), missed: (step [1-4] to .* rad, v\d\d.*)", response
    )
    assert where is not None
    assert f"({where[1]})" in told["reason"]
    reached = {one["key"]: one["best"] for one in told["search"]["reached"]}
    assert 0.1 < reached["response_time_95_s"] < 0.35


def test_an_interrupted_search_prints_the_values_of_its_best_candidate(
    spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec.write_text(EASY.replace("_95_s: 0.35", "_95_s: 0.115"))
    played: list[object] = []
    simulate = ControllerJudge._played

    def interrupted(judge: ControllerJudge, *arguments: Any) -> Any:
        played.append(arguments)
        if len(played) > 30:
            raise KeyboardInterrupt
        return simulate(judge, *arguments)

    monkeypatch.setattr(ControllerJudge, "_played", interrupted)
    controller, picture = tmp_path / "controller.yaml", tmp_path / "trade.svg"
    done = run(*_synth(spec, "-o", controller, "--plot", picture, "--json"))
    assert done.code == EXIT_INTERRUPTED
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == [spec]
    assert "searched: PI cascade, 8 candidates\nbest candidate, on 4 of 41 plants:\n" in done.stderr
    assert re.search(r"\n  response 95 % .* \(specified <= 0.115 s\), missed\n", done.stderr)
    assert re.search(r"\n  peak drive .* A \(specified <= 50 A\)\n", done.stderr)
    assert done.stderr.endswith("\ninterrupted\n")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("value: 2.5", "value: 0.1", ["static_error", "0.1 rad", "encoder's step, 0.1122 rad"]),
        ("_95_s: 0.35", "_95_s: 0.03", ["response_time_95_s", "0.03 s"]),
        ("_95_s: 0.35", "_95_s: 0.095", ["0.095 s", "a step of 50.4 rad", "--scenario"]),
    ],
)
def test_what_no_controller_can_do_is_refused_before_the_search(
    spec: Path, old: str, new: str, words: list[str]
) -> None:
    spec.write_text(EASY.replace(old, new))
    refused(run(*_synth(spec)), 4, *words)


def test_options_of_a_search_and_of_a_design_exclude_each_other(spec: Path, tmp_path: Path) -> None:
    assert "simulates its candidates" in run(*_synth(spec, "--no-play")).stderr
    design = RIG / "designs/speed.yaml"
    both = run(*_synth(spec, "--design", design, "--save-design", tmp_path / "d.yaml"))
    assert both.code == 2
    assert "--save-design saves the design that a search" in both.stderr
    empty = {**yaml.safe_load(EASY)}
    spec.write_text(
        yaml.safe_dump({key: empty[key] for key in ("format", "name", "axis", "drive")})
    )
    nothing = run(*_synth(spec))
    assert nothing.code == 3
    assert "found no requirement" in nothing.stderr


WISHES = """\
format: design/1
name: mine
axis: rotary
method: auto
weights: {}
prefilter: {natural_frequency_rad_s: 25, damping: 0.9}
"""


@pytest.mark.accept
def test_blocks_of_a_design_with_method_auto_are_kept(spec: Path, tmp_path: Path) -> None:
    design, controller = tmp_path / "wishes.yaml", tmp_path / "controller.yaml"
    design.write_text(WISHES)
    done = run(*_synth(spec, "--design", design, "-o", controller, "--json"))
    assert done.code == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["search"]["passed"]
    assert told["search"]["reserve"] == 0.05
    assert min(one["reserve"] for one in told["played"]["requirements"]) >= 0.0
    found = load(tmp_path / "controller.design.yaml", Design)
    assert (found.name, found.method) == ("mine", "pid")
    assert found.prefilter is not None
    assert (found.prefilter.natural_frequency_rad_s, found.prefilter.damping) == (25.0, 0.9)


def test_keys_that_method_auto_determines_are_refused(spec: Path, tmp_path: Path) -> None:
    design = tmp_path / "wishes.yaml"
    design.write_text(WISHES.replace("weights: {}", "weights: {bandwidth_rad_s: 40}"))
    refused(run(*_synth(spec, "--design", design)), 3, "method auto searches them")
    design.write_text(f"{WISHES}profile: {{}}\n")
    refused(run(*_synth(spec, "--design", design)), 3, "wishes.yaml:7: ", "`profile` replaces")
    design.write_text(WISHES.replace("auto", "pid"))
    refused(run(*_synth(spec, "--design", design)), 3, "structure: missing")


@pytest.mark.accept
def test_a_profile_of_a_design_with_method_auto_is_kept(spec: Path, tmp_path: Path) -> None:
    design, controller = tmp_path / "wishes.yaml", tmp_path / "controller.yaml"
    design.write_text(
        WISHES.replace("prefilter: {natural_frequency_rad_s: 25, damping: 0.9}", "profile: {}")
    )
    done = run(*_synth(spec, "--design", design, "-o", controller))
    assert done.code == 0, done.stderr
    found = load(tmp_path / "controller.design.yaml", Design)
    assert found.profile is not None
    assert found.prefilter is None


def test_a_specification_of_the_tracking_error_adds_a_profile_with_feedforward(spec: Path) -> None:
    assert _kept_blocks(load(spec, Spec), None) == {}
    spec.write_text(f"{EASY}tracking_error_peak: {{value: 6, unit: rad}}\n")
    kept = _kept_blocks(load(spec, Spec), None)
    assert kept == {
        "profile": ProfileDesign(),
        "feedforward": FeedforwardDesign(),
        "prefilter": None,
        "friction_compensation": None,
    }
    scales = design_scales(clutch_model(), load(spec, Spec), 50.0, 0.35)
    for family in FAMILIES:
        design = _with_blocks(family, kept).design(scales, family.values(family.starts[0]))
        assert design.profile is not None
        assert design.prefilter is None
    own = Design(
        format="design/1",
        name="mine",
        axis="rotary",
        method="auto",
        weights=Weights(),
        prefilter=PrefilterDesign(natural_frequency_rad_s=25.0, damping=0.9),
    )
    assert set(_kept_blocks(load(spec, Spec), own)) >= {"name", "prefilter", "feedforward"}
    assert "profile" not in _kept_blocks(load(spec, Spec), own)
