"""A rig that its controller was not verified for: another limit, encoder, winding or spring, or a
model of the bench's values."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest

from frictool.documents.bench import Encoder, Winding
from frictool.documents.digests import with_digests
from frictool.documents.laws import Laws, Load
from frictool.documents.missing_effects import missing_ringing
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.resonances import Oscillation, Resonances, Ringing
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap, write_mcap
from studies.command_line import run
from studies.rigs.campaign_rig import played
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.cli.controller_rig import CONTROLLER, ControllerRig, margin_of
from tests.support.simulated_mechanisms import ONE_BLOCK


@pytest.fixture(name="rig")
def _rig(tmp_path: Path) -> ControllerRig:
    return ControllerRig(tmp_path)


def with_bench(**fields: Any) -> Model:
    """The clutch's model with other fields of its bench."""
    model = clutch_model()
    return msgspec.structs.replace(model, bench=msgspec.structs.replace(model.bench, **fields))


def with_actuator(**fields: Any) -> Model:
    """The clutch's model with other fields of its actuator."""
    return with_bench(actuator=msgspec.structs.replace(clutch_model().bench.actuator, **fields))


def with_limit(ampere: float) -> Model:
    return with_actuator(
        limit=msgspec.structs.replace(clutch_model().bench.actuator.limit, value=ampere)
    )


def with_spring(stiffness: float) -> Model:
    spring = Estimate(value=stiffness, unit="N m/rad", source="identified")
    return msgspec.structs.replace(clutch_model(), laws=Laws(load=Load(stiffness=spring)))


OTHERS = {
    "limit": (with_limit(5.0), "drive limit 5 A, verified 50 A"),
    "encoder": (
        with_bench(encoder=Encoder(counts_per_revolution=14)),
        "encoder step 0.448799 rad, verified 0.1122 rad",
    ),
    "winding": (
        with_actuator(winding=Winding(2.0, 12.0)),
        "winding resistance 2 ohm, verified 0 ohm; winding voltage 12 V, verified none",
    ),
    "spring": (
        with_spring(0.05),
        "stiffness of a spring on the axis 0.05 N m/rad, verified 0 N m/rad",
    ),
}


@pytest.mark.parametrize("name", OTHERS)
def test_another_rig_is_named_in_every_verdict_and_leaves_the_margin_undecided(
    rig: ControllerRig, name: str
) -> None:
    model, named = OTHERS[name]
    rig.write(model, played(), 0.1)
    answer = run(
        "verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml", "--json"
    )
    told = json.loads(answer.stdout)["model"]
    assert (answer.code, told["holds"], "; ".join(told["outside"])) == (1, False, named)
    assert named in rig.simulate().stderr
    shown = rig.report("--json")
    assert shown.code == 1
    assert margin_of(shown.stdout)["met"] is None
    assert any(named in line for line in json.loads(shown.stdout)["warnings"])
    found = rig.campaign("--json")
    assert found.code == 1
    assert "modulus_margin" in json.loads(found.stdout)["undecided_requirements"]
    assert named in found.stdout


@pytest.mark.parametrize(("stiffness", "covered"), [(4e-4, True), (6e-4, False)])
def test_a_spring_up_to_the_verified_one_is_covered(
    rig: ControllerRig, stiffness: float, covered: bool
) -> None:
    rig.write(with_spring(stiffness), played(), 0.1)
    verified = Estimate(5e-4, unit="N m/rad", source="identified")
    controller = with_digests(msgspec.structs.replace(CONTROLLER, stiffness=verified))
    (rig.folder / "controller.yaml").write_text(to_yaml(controller))
    named = "spring on the axis 0.0006 N m/rad, verified 0 to 0.0005 N m/rad"
    assert (named in rig.simulate().stderr) != covered
    shown = rig.report("--json")
    assert margin_of(shown.stdout)["met"] is (True if covered else None)
    assert any(named in line for line in json.loads(shown.stdout)["warnings"]) != covered


def test_saturation_is_judged_by_the_limit_that_was_played(rig: ControllerRig) -> None:
    """A drive that gives 0.5 A where the controller asks for 50 A is at its limit for most of the
    step."""
    rig.write(with_limit(0.5), played(), 0.1)
    spec = rig.folder / "spec.yaml"
    spec.write_text(spec.read_text() + "saturation_time_s: 0.001\n")
    rig.simulate()
    outcome = {one["name"]: one for one in json.loads(rig.report("--json").stdout)["requirements"]}[
        "saturation_time"
    ]
    assert outcome["met"] is False
    assert outcome["value"] > 0.01


@pytest.mark.parametrize(
    "lost", ["the whole record", "loop_time_constant_s", "not a number", "interval"]
)
def test_a_log_that_does_not_state_its_rig_leaves_the_margin_undecided(
    rig: ControllerRig, lost: str
) -> None:
    """As a log of an earlier version."""
    rig.write(clutch_model(), played(), 0.1)
    rig.simulate()
    log = read_mcap(rig.folder / "run.mcap")
    record, named = log.metadata["played_rig"], "time constant of the drive"
    if lost == "the whole record":
        del log.metadata["played_rig"]
    elif lost == "interval":
        log.metadata["model_intervals"]["viscous"] = "[NaN, 7.62e-4]"
        named = "interval of viscous"
    elif lost == "not a number":
        record["loop_time_constant_s"] = "NaN"
    else:
        del record[lost]
    with (rig.folder / "run.mcap").open("wb") as stream:
        write_mcap(log, stream)
    shown = rig.report("--json")
    reason = str(margin_of(shown.stdout)["reason"])
    assert (shown.code, margin_of(shown.stdout)["met"]) == (1, None)
    assert named in reason
    assert (
        "frictool simulate model.yaml --controller controller.yaml --scenario scenario.yaml -o "
        in reason
    )


def test_the_bench_of_a_recorded_log_is_compared_with_the_controller_s(rig: ControllerRig) -> None:
    rig.write(clutch_model(), played(), 0.1)
    rig.simulate()
    log = read_mcap(rig.folder / "run.mcap")
    log.metadata["log"]["kind"] = "recorded"
    with (rig.folder / "run.mcap").open("wb") as stream:
        write_mcap(log, stream)
    own, other = rig.folder / "own.yaml", rig.folder / "other.yaml"
    own.write_text(to_yaml(CONTROLLER.bench))
    actuator = msgspec.structs.replace(CONTROLLER.bench.actuator, loop_time_constant_s=0.02)
    other.write_text(to_yaml(msgspec.structs.replace(CONTROLLER.bench, actuator=actuator)))
    assert rig.report("--bench", own).code == 0
    shown = rig.report("--bench", other, "--json")
    assert (shown.code, margin_of(shown.stdout)["met"]) == (1, None)
    assert "time constant of the drive 0.02 s, verified 0.003 s" in str(
        json.loads(shown.stdout)["warnings"]
    )


def test_a_model_of_the_bench_s_values_is_named_by_every_command_and_verdict(
    rig: ControllerRig,
) -> None:
    rig.write(
        msgspec.structs.replace(clutch_model(), bench_values_only="the sign is reversed"),
        played(),
        0.1,
    )
    named = "contains only the bench's values (the sign is reversed)"
    assert named in rig.simulate().stderr
    assert rig.simulate().stderr.count(named) == 1
    for done in (rig.report("--json"), rig.campaign("--json")):
        assert named in str(json.loads(done.stdout)["warnings"])
    assert (
        named
        in run(
            "verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml"
        ).stderr
    )


def test_every_command_warns_of_a_ringing_that_the_model_lacks(rig: ControllerRig) -> None:
    rung = Ringing(100.0, 0.02, (98.0, 102.0))
    lacking = msgspec.structs.replace(clutch_model(), ringing=rung)
    text = "after stops, the position rings at 15.9 Hz (15.6 to 16.2 Hz)"
    rig.write(lacking, played(), 0.1)
    model = rig.folder / "model.yaml"
    assert text in rig.simulate().stderr
    assert text in run("verify", rig.folder / "controller.yaml", "--model", model).stderr
    design = ROOT / "configs/clutch/designs/speed.yaml"
    options = ("--spec", rig.folder / "spec.yaml", "--design", design)
    assert text in run("synth", model, *options, "--vertices-only", "--no-play").stderr
    known = Resonances(links=("belt",), poles=(rung,))
    assert missing_ringing(msgspec.structs.replace(lacking, resonances=known)) is None


def test_verify_computes_the_margin_with_the_resonances_of_the_model(rig: ControllerRig) -> None:
    """The controller was designed without them; a link that rings near its bandwidth makes its loop
    unstable."""
    soft = Resonances(links=("belt",), poles=(Oscillation(30.0, 0.01),))
    rig.write(msgspec.structs.replace(clutch_model(), resonances=soft), played(), 0.1)
    answer = run(
        "verify", rig.folder / "controller.yaml", "--model", rig.folder / "model.yaml", "--json"
    )
    told = json.loads(answer.stdout)["model"]
    assert (answer.code, told["holds"], told["modulus_margin_with_resonances"]) == (1, False, 0.0)


def test_a_plant_beyond_the_certificate_is_named_though_its_own_margin_holds(
    rig: ControllerRig,
) -> None:
    """`given` makes one plant stronger than the controller was verified for, within a model that it
    was verified for."""
    rig.write(
        clutch_model(),
        played(variants="given", given={"constant": Quantity(value=0.0145, unit="N m/A")}),
        0.1,
    )
    assert rig.simulate().stderr == ""
    shown = rig.report("--json")
    assert (shown.code, margin_of(shown.stdout)["met"]) == (0, True)
    named = (
        "run.mcap: simulated plants are outside the intervals for which speed was verified: "
        "constant 0.0145 N m/A, verified"
    )
    assert any(line.startswith(named) for line in json.loads(shown.stdout)["warnings"])


def test_the_verdict_names_a_block_that_was_changed_after_the_verification(
    rig: ControllerRig,
) -> None:
    rig.write(clutch_model(), played(), 0.1)
    verified = with_digests(CONTROLLER)
    assert verified.position_law is not None
    law = msgspec.structs.replace(verified.position_law, gain=0.9 * verified.position_law.gain)
    (rig.folder / "controller.yaml").write_text(
        to_yaml(msgspec.structs.replace(verified, position_law=law))
    )
    rig.simulate()
    named = (
        "speed: changed after it was verified: position_law; `frictool verify` lists the "
        "properties that still hold"
    )
    shown = rig.report("--json")
    assert named in json.loads(shown.stdout)["warnings"]
    assert named in json.loads(rig.campaign("--json").stdout)["warnings"]


def test_a_mechanism_with_another_drive_is_named_in_every_verdict(rig: ControllerRig) -> None:
    """Its margin is undecided anyway; the drive's limit and constant are compared."""
    rig.write(clutch_model(), played(), 0.1)
    changed = ONE_BLOCK.replace("value: 50, unit: A", "value: 5, unit: A")
    assert changed != ONE_BLOCK
    (rig.folder / "model.yaml").write_text(changed)
    named = "drive limit 5 A, verified 50 A"
    assert named in rig.simulate().stderr
    assert named in str(json.loads(rig.report("--json").stdout)["warnings"])
