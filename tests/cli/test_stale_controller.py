"""A model that its controller was not verified for: its own vertices are played, its own margins
judged, and every verdict names it."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec
import pytest

from frictool.documents.model import Model
from frictool.logs.canonical.mcap_format import read_mcap, write_mcap
from frictool.plant.polytope import PlantPoint
from frictool.verify.document_check import check_feedback
from frictool.verify.feedback_loops import feedbacks_of
from studies.command_line import run
from studies.rigs.campaign_rig import played
from studies.rigs.clutch_model import clutch_model
from tests.cli.controller_rig import CONTROLLER, ControllerRig, margin_of
from tests.support.simulated_mechanisms import ONE_BLOCK

OUTSIDE = "inertia {} to 1.53e-05 kg m^2, verified 1.11e-05 to 1.53e-05"


def with_inertia(low: float, high: float) -> Model:
    """The clutch's model, its identified inertia in another interval; its bench has the usual range
    over the product's life."""
    model = clutch_model()
    inertia = msgspec.structs.replace(
        model.parameters.inertia, value=0.5 * (low + high), low=low, high=high
    )
    return msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, inertia=inertia)
    )


def margin_at(inertia: float, viscous: float, constant: float) -> float:
    """Return the modulus margin of the rebuilt loop."""
    rates = PlantPoint("", inertia, viscous, 0.1, constant).rates
    return min(
        check_feedback(
            loop, rates, CONTROLLER.bench.actuator.loop_time_constant_s, 1
        ).modulus_margin
        for loop in feedbacks_of(CONTROLLER)
    )


@pytest.fixture(name="rig")
def _rig(tmp_path: Path) -> ControllerRig:
    return ControllerRig(tmp_path)


def test_a_margin_that_the_played_plant_misses_is_broken_though_the_controller_s_vertices_have_it(
    rig: ControllerRig,
) -> None:
    """The light ends of the model's own ranges, with the least friction and the strongest drive."""
    vertices = min(vertex.modulus_margin for vertex in CONTROLLER.verified.vertices)
    true = margin_at(4.9e-6, 0.0, 14.0e-3)
    limit = 0.5 * (vertices + true)
    assert true < limit < vertices
    rig.write(with_inertia(4.9e-6, 5.1e-6), played(variants="vertices"), limit)
    assert OUTSIDE.format("4.9e-06") in rig.simulate().stderr
    shown = rig.report("--json")
    assert shown.code == 1
    found = margin_of(shown.stdout)
    assert found["met"] is False
    assert found["value"] == pytest.approx(true, rel=1e-5)
    assert found["where"] == {"log": "run.mcap", "stream": "/axis/v02"}
    assert json.loads(shown.stdout)["verdict"] == "fail"
    streams = {one["stream"]: one["modulus_margin"] for one in json.loads(shown.stdout)["streams"]}
    assert streams["/axis/v16"] == pytest.approx(margin_at(1.53e-5, 7.62e-4, 14.0e-3), rel=1e-5)


def test_a_model_outside_is_undecided_and_named_in_every_output(rig: ControllerRig) -> None:
    rig.write(with_inertia(1.0e-5, 1.2e-5), played(variants="vertices"), 0.1)
    rig.simulate()
    page, suite, table = (rig.folder / f"report.{kind}" for kind in ("html", "xml", "md"))
    shown = rig.report("-o", page, "--junit", suite, "--markdown", table)
    assert shown.code == 1
    assert shown.stdout.splitlines()[-1].startswith("UNDECIDED: ")
    named = OUTSIDE.format("1e-05")
    told = json.loads(rig.report("--json").stdout)
    assert margin_of(json.dumps(told))["met"] is None
    assert any(named in line for line in told["warnings"])
    warnings = [
        one.get("value", "")
        for one in ET.parse(suite).getroot().iter("property")
        if one.get("name") == "warning"
    ]
    for text in (shown.stdout, page.read_text(), table.read_text().replace("\\", ""), *warnings):
        assert named in text
    assert rig.report("--allow-undecided").code == 0
    found = rig.campaign("-o", rig.folder / "found.html", "--json")
    assert found.code == 1
    assert json.loads(found.stdout)["undecided_requirements"] == ["modulus_margin"]
    assert json.loads(found.stdout)["verdict"] == "undecided"
    for text in (found.stdout, rig.campaign().stdout, (rig.folder / "found.html").read_text()):
        assert named in text


def test_coulomb_friction_outside_is_undecided_and_named_though_no_margin_depends_on_it(
    rig: ControllerRig,
) -> None:
    model = clutch_model()
    coulomb = msgspec.structs.replace(model.parameters.coulomb, value=0.25, low=0.24, high=0.26)
    rig.write(
        msgspec.structs.replace(
            model, parameters=msgspec.structs.replace(model.parameters, coulomb=coulomb)
        ),
        played(),
        0.1,
    )
    named = "to 0.26 N m, verified"
    assert named in rig.simulate().stderr
    shown = rig.report("--json")
    assert shown.code == 1
    assert margin_of(shown.stdout)["met"] is None
    assert any(named in line for line in json.loads(shown.stdout)["warnings"])
    found = json.loads(rig.campaign("--json").stdout)
    assert found["verdict"] == "undecided"


def test_a_model_within_is_judged_by_the_margins_of_what_was_played(rig: ControllerRig) -> None:
    rig.write(clutch_model(), played(variants="vertices"), 0.1)
    assert "warning" not in rig.simulate().stderr
    shown = rig.report("--json")
    corners = [
        margin_at(j, s, k)
        for j in (1.11e-5, 1.53e-5)
        for s in (0.0, 7.62e-4)
        for k in (12.8e-3, 14.0e-3)
    ]
    assert (shown.code, margin_of(shown.stdout)["met"]) == (0, True)
    assert margin_of(shown.stdout)["value"] == pytest.approx(min(corners), rel=1e-5)
    assert json.loads(shown.stdout)["warnings"] == []


def test_a_campaign_has_the_margin_of_each_draw(rig: ControllerRig) -> None:
    rig.write(clutch_model(), played(), 0.1)
    rows = rig.folder / "rows.csv"
    assert rig.campaign("--table", rows).code == 0
    heads, *found = [line.split(",") for line in rows.read_text().splitlines()]
    for row in found:
        values = {head.split(" [")[0]: text for head, text in zip(heads, row, strict=True)}
        true = margin_at(*(float(values[name]) for name in ("inertia", "viscous", "constant")))
        assert float(values["modulus_margin"]) == pytest.approx(true, rel=1e-5)
    assert len({row[heads.index("modulus_margin")] for row in found}) == 12


def test_draws_beyond_the_certificate_are_named_and_judged_by_their_own_margins(
    rig: ControllerRig,
) -> None:
    from frictool.documents.spread import Spread, Temperature, Warmth

    rig.write(
        clutch_model(), played(Spread(temperature=Temperature(Warmth(), Warmth(constant=0.9)))), 0.1
    )
    found = rig.campaign()
    assert found.code == 0
    assert "draws are outside the intervals for which speed was verified" in found.stdout
    assert "constant 0.01152 to 0.014 N m/A, verified 0.0128 to 0.014" in found.stdout


@pytest.mark.parametrize("broken", ["no record", "no plant"])
def test_a_log_that_does_not_describe_its_plant_leaves_the_margin_undecided(
    rig: ControllerRig, broken: str
) -> None:
    rig.write(clutch_model(), played(), 0.1)
    rig.simulate()
    log = read_mcap(rig.folder / "run.mcap")
    if broken == "no record":
        del log.metadata["played_plants"]
    else:
        log.metadata["played_plants"]["/axis"] = "{}"
    with (rig.folder / "run.mcap").open("wb") as stream:
        write_mcap(log, stream)
    shown = rig.report("--json")
    assert shown.code == 1
    assert margin_of(shown.stdout)["met"] is None
    assert "does not describe its plant" in str(margin_of(shown.stdout)["reason"])


def test_the_margin_on_a_mechanism_is_undecided(rig: ControllerRig) -> None:
    rig.write(clutch_model(), played(), 0.1)
    (rig.folder / "model.yaml").write_text(ONE_BLOCK)
    rig.simulate()
    shown = rig.report("--json")
    assert (shown.code, json.loads(shown.stdout)["undecided"]) == (1, ["modulus_margin"])


@pytest.mark.parametrize(("low", "holds"), [(1.11e-5, True), (4.9e-6, False)])
def test_verify_answers_for_a_model_alone(rig: ControllerRig, low: float, holds: bool) -> None:
    """The example has no certificate, which is exit code 1 by itself; what is said of the model is
    the same."""
    rig.write(with_inertia(low, 1.53e-5), played(), 0.1)
    done = run(
        "verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml", "--json"
    )
    told = json.loads(done.stdout)["model"]
    assert (done.code, bool(told["outside"])) == (1, not holds)
    assert told["modulus_margin"] == pytest.approx(margin_at(low, 0.0, 14.0e-3), rel=1e-5)
    assert told["at"]["inertia"] == low
    text = run(
        "verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml"
    ).stdout
    assert ("not covered by the controller's verification: inertia" in text) is not holds


def test_verify_refuses_a_model_of_another_bench(rig: ControllerRig) -> None:
    model = clutch_model()
    other = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, delay_samples=2)
    )
    rig.write(other, played(), 0.1)
    done = run("verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml")
    assert done.code == 3
    assert "delay_samples is 2 in the model" in done.stderr


@pytest.mark.parametrize("lag", [0.0, 0.006])
def test_a_model_whose_drive_has_another_time_constant_is_not_played(
    rig: ControllerRig, lag: float
) -> None:
    """The margins of the controller's drive say nothing of a slower or faster one."""
    model = clutch_model()
    actuator = msgspec.structs.replace(model.bench.actuator, loop_time_constant_s=lag)
    rig.write(
        msgspec.structs.replace(
            model, bench=msgspec.structs.replace(model.bench, actuator=actuator)
        ),
        played(variants="vertices"),
        0.1,
    )
    model_file, controller_file, scenario = (
        rig.folder / f"{name}.yaml" for name in ("model", "controller", "scenario")
    )
    named = (
        f"bench.actuator.loop_time_constant_s: found 0.003, but the bench of {model_file} has {lag}"
    )
    message = f"{named}; synthesise again for this bench"
    output = rig.folder / "run.mcap"
    simulated = run(
        "simulate",
        model_file,
        "--controller",
        controller_file,
        "--scenario",
        scenario,
        "-o",
        output,
    )
    for done in (simulated, rig.campaign("-o", rig.folder / "found.html")):
        assert done.code == 3
        assert message in done.stderr
    assert not output.exists()
