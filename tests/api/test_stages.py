"""Stages called by a program: documents and logs in memory, what they give, what they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.campaign import CampaignRequest, campaign, campaign_run
from frictool.campaign.views.json_view import as_json
from frictool.cli.campaign import TRIALS
from frictool.documents import Bench, Mechanism, Model, Scenario, Spec, load, save, to_yaml
from frictool.documents.provenance import digest, provenance_of_call
from frictool.documents.quantity import Span
from frictool.documents.spread import Spread
from frictool.engine.bench_position_loop import PositionServo
from frictool.equations import equations
from frictool.errors import (
    DocumentError,
    FrictoolError,
    InputFileError,
    LogError,
    NoSolutionError,
    OutputError,
)
from frictool.export import export
from frictool.identify import NothingIdentified, identify
from frictool.identify.assess import AssessmentRequest, assess
from frictool.identify.excite import ExcitationSettings, excite
from frictool.identify.info import info
from frictool.identify.info.text_view import table
from frictool.identify.validate import validate
from frictool.logs import IngestRequest, ingest, log_of, read_log, write_log
from frictool.logs.log_assembly import TimeWindow
from frictool.observe import design_observer, observe
from frictool.reduce import ReductionRequest, reduce
from frictool.reduce.partial_travel import OutsideTravelError
from frictool.report import judge
from frictool.simulate import play, simulate
from studies.command_line import run
from studies.rigs import campaign_rig as rig
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller
from studies.rigs.verified_controller import truthful
from tests.support.short_logs import first_part

MODEL = clutch_model()
BENCH = MODEL.bench
CLUTCH = ROOT / "configs/clutch"


def test_a_document_says_what_it_is(tmp_path: Path) -> None:
    assert isinstance(load(CLUTCH / "bench.yaml"), Bench)
    assert isinstance(load(str(CLUTCH / "mechanism.yaml")), Mechanism)
    (tmp_path / "a.yaml").write_text("name: a\n")
    with pytest.raises(DocumentError, match="format: missing"):
        load(tmp_path / "a.yaml")
    (tmp_path / "b.yaml").write_text("name: a\nformat: bensh/1\n")
    with pytest.raises(
        DocumentError, match=r"b\.yaml:2: format: found 'bensh/1'; allowed: bench/1"
    ):
        load(tmp_path / "b.yaml")
    (tmp_path / "c.yaml").write_text("- 1\n")
    with pytest.raises(DocumentError, match="format: missing"):
        load(tmp_path / "c.yaml")
    with pytest.raises(InputFileError, match="no such file"):
        load(tmp_path / "d.yaml")


def test_what_is_saved_is_what_is_loaded_and_what_provenance_names(tmp_path: Path) -> None:
    save(MODEL, tmp_path / "model.yaml")
    assert load(tmp_path / "model.yaml", Model) == MODEL
    (named,) = provenance_of_call("a function", model=MODEL, observer=None).inputs
    assert (named.name, named.sha256) == ("model.yaml", digest(tmp_path / "model.yaml"))
    assert [path.name for path in tmp_path.iterdir()] == ["model.yaml"]
    with pytest.raises(OutputError, match="cannot be written"):
        save(MODEL, tmp_path / "missing" / "model.yaml")
    with pytest.raises(OutputError, match="cannot be written"):
        write_log(
            log_of([0.0, 1.0], {"position": [0.0, 1.0]}, "rotary"),
            tmp_path / "missing" / "log.mcap",
        )


def test_a_log_of_arrays_is_a_log(tmp_path: Path) -> None:
    time = np.arange(50) * 1e-3
    log = log_of(
        time, {"position": np.sin(time), "current": np.cos(time)}, axis="rotary", name="mine"
    )
    assert log.main.units == {"position": "rad", "current": "A"}
    write_log(log, tmp_path / "mine.mcap")
    again = read_log(str(tmp_path / "mine.mcap")).main
    np.testing.assert_array_equal(again.signals["position"], log.main.signals["position"])
    log.main.signals["position"][0] = 7.0  # is a copy: what it was made from is not touched
    assert time[0] == 0.0


def test_files_are_ingested_as_by_the_command(tmp_path: Path) -> None:
    raw = ROOT / "sample_logs/steps.csv"
    request = IngestRequest(TimeWindow.between(1.0, 1.5), 0.002, unit="A7", date="2026-01-03")
    made = ingest([raw], tmp_path / "called.mcap", BENCH, request)
    assert [base.samples for _, base in made.streams] == [251]
    window = ["--from", "1", "--to", "1.5", "--resample", "0.002"]
    facts = ["--unit", "A7", "--date", "2026-01-03", "-o", tmp_path / "run.mcap"]
    assert run("ingest", raw, "--bench", CLUTCH / "bench.yaml", *window, *facts).code == 0
    called, commanded = (read_log(tmp_path / f"{name}.mcap") for name in ("called", "run"))
    for name, signal in commanded.main.signals.items():
        np.testing.assert_array_equal(called.main.signals[name], signal)
    origins = [dict(log.metadata.pop("provenance")) for log in (called, commanded)]
    assert called.metadata == commanded.metadata
    assert origins[0]["input_1"] == origins[1]["input_1"]
    assert origins[0]["command"] == "frictool.logs.ingest() in Python"
    for wrong in ({"kind": "walk"}, {"date": "yesterday"}, {"period_s": 0.0}):
        (name,) = wrong
        with pytest.raises(FrictoolError, match=f"{name}: found .*; allowed: "):
            ingest([raw], tmp_path / "wrong.mcap", BENCH, IngestRequest(**wrong))
    with pytest.raises(OutputError, match="cannot be written"):
        ingest([raw], tmp_path / "missing" / "steps.mcap", BENCH)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["called.mcap", "run.mcap"]


@pytest.mark.parametrize(
    ("time", "signals", "words"),
    [
        ([0.0, 1.0], {}, "channels: found none"),
        ([0.0, 1.0], {"postion": [0.0, 1.0]}, "channels: found postion; allowed: position"),
        ([0.0, 1.0], {"position": [0.0]}, "position has 1 samples, time has 2"),
        ([0.0, 1.0], {"position": [0.0, np.nan]}, "finite"),
        ([0.0, 1.0], {"position": [[0.0, 1.0]]}, "vector"),
        ([1.0, 1.0], {"position": [0.0, 1.0]}, "time does not increase"),
        ([], {"position": []}, "fewer than 2"),
    ],
)
def test_arrays_that_are_no_log_are_refused(
    time: list[float], signals: dict[str, list[float]], words: str
) -> None:
    with pytest.raises(LogError, match=words):
        log_of(time, signals, "rotary")


def test_a_test_is_planned_played_identified_and_validated() -> None:
    """The whole way of a bench in memory: what is found is what was put in."""
    sines = excite("sines", BENCH, ExcitationSettings(duration=4.0, speeds=3))
    servo = PositionServo(proportional=30.0 * 0.1 * 13.4e-3, derivative=0.1 * 13.4e-3)
    log = play(MODEL, sines.as_log("sines"), servo=servo, drive_noise=0.02, seed=3)
    found = identify([log], BENCH)
    assert found.model.parameters.coulomb.value == pytest.approx(
        MODEL.parameters.coulomb.value, rel=0.02
    )
    assert found.model.provenance.command == "frictool.identify.identify() in Python"
    assert found.records[0].time.size == log.main.time.size
    assert validate(found.model, log).errors["velocity"] < 0.2
    with pytest.raises(LogError, match="give `servo`"):
        play(MODEL, sines.as_log("sines"))


def test_a_function_gives_what_its_command_writes(tmp_path: Path) -> None:
    path, bench = ROOT / "sample_logs/ramp.csv", CLUTCH / "bench.yaml"
    assert run("identify", path, "--bench", bench, "-o", tmp_path / "model.yaml").code == 0
    written, found = (
        load(tmp_path / "model.yaml", Model),
        identify([read_log(path, BENCH)], load(bench, Bench)).model,
    )
    assert written.parameters == found.parameters
    without = [
        line
        for line in to_yaml(found).splitlines()
        if line not in (tmp_path / "model.yaml").read_text().splitlines()
    ]
    assert all("Python" in line or "sha256" in line or "bench.yaml" in line for line in without), (
        without
    )


def test_a_log_that_tells_nothing_says_so() -> None:
    time, still = np.arange(3000) * 1e-3, np.zeros(3000)
    with pytest.raises(NothingIdentified) as refused:
        identify([log_of(time, {"position": still, "current": still}, "rotary")], BENCH)
    assert {"inertia", "coulomb"} <= refused.value.result.refused.keys()


def test_what_a_bench_can_tell_is_asked_before_it_runs() -> None:
    rows = {
        row.parameter: row.verdict
        for row in assess(BENCH, AssessmentRequest({"inertia": 0.05})).rows
    }
    assert rows["coulomb"].identifiable


def test_what_a_log_holds_is_told_of_one_in_memory_and_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "sines.csv"
    path.write_text(first_part("sines.csv", 5000))
    of_file = info(path, BENCH)
    assert table(of_file) + "\n" == run("info", path, "--bench", CLUTCH / "bench.yaml").stdout
    assert {"format": "info/1", **of_file.facts} == json.loads(
        run("info", path, "--bench", CLUTCH / "bench.yaml", "--json").stdout
    )
    in_memory = info(read_log(path, BENCH), BENCH)
    assert in_memory.facts["test"] == of_file.facts["test"] == {"kind": "sines", "given": False}
    assert in_memory.facts["encoder_step"] == of_file.facts["encoder_step"]


def test_a_model_needs_a_controller_and_a_mechanism_its_sources() -> None:
    scenario = load(CLUTCH / "scenarios/steps.yaml", Scenario)
    with pytest.raises(DocumentError, match="without a controller; give a controller"):
        simulate(MODEL, None, scenario)
    with pytest.raises(FrictoolError):
        simulate(load(CLUTCH / "mechanism.yaml", Mechanism), None, scenario)


def test_a_scenario_that_replays_a_log_asks_for_it() -> None:
    replay = load(CLUTCH / "scenarios/replay.yaml", Scenario)
    for stage in (simulate, lambda *documents: campaign(*documents, clutch_spec())):
        with pytest.raises(DocumentError, match=r"scenario: reference\.log: names a log to replay"):
            stage(MODEL, truthful(controller()), replay)


def test_a_mechanism_is_reduced_to_its_model() -> None:
    screw = load(ROOT / "configs/screw/reversible.yaml", Mechanism)
    found = reduce(screw)
    assert found.model.provenance.command == "frictool.reduce.reduce() in Python"
    assert found.checked.refused is None
    low, high = found.chain.one.travel
    half = reduce(screw, ReductionRequest(travel=(low, 0.5 * (low + high))))
    assert half.chain.one.travel == pytest.approx((low, 0.5 * (low + high)))
    with pytest.raises(NoSolutionError, match=r"lies beyond its end stops at 0 and 9\.425 rad"):
        reduce(screw, ReductionRequest(travel=(high + 1.0, high + 2.0)))
    with pytest.raises(OutsideTravelError, match="found 2 to 1; allowed: LOW < HIGH"):
        reduce(screw, ReductionRequest(travel=(2.0, 1.0)))


def test_equations_of_a_mechanism_are_those_of_the_command() -> None:
    path = CLUTCH / "mechanism.yaml"
    found = equations(load(path, Mechanism))
    assert found.text == run("equations", path).stdout
    assert found.latex == run("equations", path, "--latex").stdout
    assert {"format": "equations/1", **found.data} == json.loads(
        run("equations", path, "--json").stdout
    )


def test_a_mechanism_that_is_none_is_told_by_its_key() -> None:
    without = msgspec.structs.replace(load(CLUTCH / "mechanism.yaml", Mechanism), blocks={})
    for stage in (equations, reduce):
        with pytest.raises(DocumentError, match=r"^mechanism: (blocks|links|control|sensors)"):
            stage(without)


def test_an_observer_is_designed_and_a_log_observed(tmp_path: Path) -> None:
    observer = design_observer(MODEL, "tracking", bandwidth_rad_s=200.0)
    assert observer.kind == "tracking"
    log = read_log(ROOT / "sample_logs/steps.csv", BENCH)
    write_log(log, tmp_path / "steps.mcap")
    seen, again = observe(MODEL, log), observe(MODEL, tmp_path / "steps.mcap")
    assert seen.outcome.estimate == again.outcome.estimate
    np.testing.assert_array_equal(
        seen.estimates.main.signals["velocity"], again.estimates.main.signals["velocity"]
    )


def test_a_campaign_says_what_its_command_says_and_its_worst_case_is_played_again(
    tmp_path: Path,
) -> None:
    command = rig.write(tmp_path, rig.played(rig.EVERYTHING))
    result = run(
        *command,
        "-n",
        "4",
        "--cores",
        "1",
        "--worst",
        tmp_path / "worst",
        "--evaluations",
        "8",
        "--json",
    )
    plant, own, scenario, spec = (
        load(tmp_path / f"{name}.yaml") for name in ("model", "controller", "scenario", "spec")
    )
    found = campaign(plant, own, scenario, spec, CampaignRequest(trials=4, evaluations=8))
    assert json.loads(json.dumps(as_json(found.findings)).replace("NaN", "null")) == json.loads(
        result.stdout
    )
    case = next(one for one in found.worst if one.requirement == "overshoot")
    again = judge(spec, [simulate(plant, own, case.played)], own)
    assert case.value == next(one.value for one in again.requirements if one.name == "overshoot")
    assert campaign_run.TRIALS == TRIALS


def test_a_campaign_that_cannot_be_is_told_by_its_documents() -> None:
    documents = MODEL, truthful(controller()), rig.played(), clutch_spec()
    with pytest.raises(DocumentError, match=r"scenario: spread.start: .*the travel of the bench"):
        campaign(*documents[:2], rig.played(Spread(start=Span(-5.0, 9.0, "rad"))), documents[3])
    with pytest.raises(DocumentError, match="spec: has no requirement that a run can decide"):
        campaign(*documents[:3], Spec(format="spec/1", name="none", axis="rotary", drive="current"))
    source = load(CLUTCH / "mechanism.yaml", Mechanism)
    with pytest.raises(DocumentError, match=r"model: control\.source: found"):
        campaign(msgspec.structs.replace(source, sources={}), *documents[1:])
    for wrong in (
        {"method": "sobol"},
        {"trials": 0},
        {"at_least": 1.5},
        {"confidence": 1.0},
        {"evaluations": -1},
        {"seed": -1},
        {"cores": 0},
        {"number": "int8"},
    ):
        (name,) = wrong
        with pytest.raises(FrictoolError, match=f"{name}: found .*; allowed: "):
            campaign(*documents, CampaignRequest(**wrong))


def test_words_that_are_none_are_refused_with_those_that_are() -> None:
    with pytest.raises(
        FrictoolError, match="kind: found 'sliding'; allowed: multiplicative, additive, tracking"
    ):
        design_observer(MODEL, "sliding")
    with pytest.raises(
        FrictoolError, match="language: found 'fortran'; allowed: c, json, cmsis, matlab"
    ):
        export(truthful(controller()), "fortran")
    with pytest.raises(
        FrictoolError, match="number: found 'int8'; allowed: double, float, q31, q15"
    ):
        export(truthful(controller()), "c", "int8")
    with pytest.raises(LogError, match="axis: found 'rotatory'; allowed: rotary, linear"):
        log_of([0.0, 1.0], {"position": [0.0, 1.0]}, "rotatory")
    with pytest.raises(FrictoolError, match="there is no log to judge"):
        judge(clutch_spec(), [])
