"""`frictool reduce` from the command line: what it writes, what it tells, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest

from frictool.documents.bench import Bench
from frictool.documents.mechanism import (
    Compliance,
    Control,
    Coupling,
    Mechanism,
    Sensor,
    Source,
    Stop,
)
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.small_mechanisms import belt, coulomb, lift, lossy_train, motor, rotor, two_plays

GOLDEN = Path(__file__).parents[1] / "reduce" / "golden" / "model.yaml"
Q = Quantity


@pytest.fixture(scope="module")
def train(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A gear train that loses, with an interval, and what `reduce` makes of it."""
    folder = tmp_path_factory.mktemp("train")
    whole = lossy_train()
    heavier = msgspec.structs.replace(
        whole, blocks={**whole.blocks, "motor": rotor(3e-5, 2.7e-5, 3.3e-5)}
    )
    _write(folder / "mechanism.yaml", heavier)
    result = run(
        "reduce",
        folder / "mechanism.yaml",
        "-o",
        folder / "model.yaml",
        "--reduced",
        folder / "reduced.yaml",
        "--json",
    )
    assert result.code == 0, result.stderr
    (folder / "told.json").write_text(result.stdout)
    return folder


def _write(path: Path, mechanism: Mechanism) -> Path:
    path.write_text(to_yaml(mechanism))
    return path


def test_the_model_is_the_golden_one_byte_for_byte(train: Path) -> None:
    assert (train / "model.yaml").read_text() == GOLDEN.read_text()


def test_its_numbers_are_those_of_the_closed_form(train: Path) -> None:
    model = load(train / "model.yaml", Model)
    ratio, table = 0.25, 0.02 * 0.25
    inertia = 3e-5 + ratio**2 * 2e-4 + table**2 * 0.4
    assert model.parameters.inertia.value == pytest.approx(
        inertia / ratio**2, rel=1e-12
    )  # where the encoder is
    beyond, back = inertia - 3e-5, 2.0 - 1.0 / 0.9
    # coasting the gear gives back 2 - 1/0.9 of what lies beyond it, accelerating it takes 1/0.9
    assert model.parameters.inertia.low == pytest.approx(
        (27e-6 + back * beyond) / ratio**2, rel=1e-9
    )
    assert model.parameters.inertia.high == pytest.approx(
        (33e-6 + beyond / 0.9) / ratio**2, rel=1e-9
    )
    # friction beyond the gear is carried through it: 1/0.9 of it at the motor
    assert model.parameters.coulomb.value == pytest.approx(
        (0.01 + table * 6.0 / 0.9) / ratio, rel=1e-9
    )
    assert model.bench.actuator.constant.value == pytest.approx(0.05 / ratio, rel=1e-12)
    assert model.bench.encoder.direction == -1  # an external gear
    assert model.method == "reduced"


def test_each_step_tells_what_it_neglects_and_both_errors(train: Path) -> None:
    told = json.loads((train / "told.json").read_text())
    steps = {step["step"]: step for step in told["steps"]}
    assert list(steps) == [
        "coordinates",
        "rigid links",
        "losses",
        "resisting curve",
        "sensor",
        "one inertia",
    ]
    for name in (
        "coordinates",
        "rigid links",
        "sensor",
        "one inertia",
    ):  # exact ones: nothing but rounding
        assert steps[name]["neglects"] == "nothing"
        assert steps[name]["measured"]["share"] < 1e-6
    losses = steps["losses"]
    beyond = 0.25**2 * 2e-4 + 0.005**2 * 0.4
    assert losses["expected_error"] == pytest.approx(
        (1.0 / 0.9 - 1.0) * beyond / (3e-5 + beyond), rel=1e-9
    )
    assert losses["covered_by"] == "the inertia's interval"
    assert 1e-3 < losses["measured"]["share"] < losses["expected_error"]
    assert told["reduced"] is True


def test_the_reduced_mechanism_is_one_that_can_be_reduced_again(train: Path) -> None:
    result = run("reduce", train / "reduced.yaml", "-o", train / "again.yaml")
    assert result.code == 0, result.stderr
    first, second = load(train / "model.yaml", Model), load(train / "again.yaml", Model)
    assert second.parameters.inertia.value == pytest.approx(
        first.parameters.inertia.value, rel=1e-12
    )
    assert second.parameters.coulomb.value == pytest.approx(
        first.parameters.coulomb.value, rel=1e-9
    )


def test_a_bench_of_another_rig_is_refused(train: Path) -> None:
    own = load(train / "model.yaml", Model).bench
    actuator = msgspec.structs.replace(own.actuator, constant=Q(0.3, unit="N m/A"))
    (train / "bench.yaml").write_text(to_yaml(msgspec.structs.replace(own, actuator=actuator)))
    assert load(train / "bench.yaml", Bench).actuator.constant.value == 0.3
    refused(
        run("reduce", train / "mechanism.yaml", "--bench", train / "bench.yaml"),
        4,
        "actuator.constant: found 0.3, but 0.2 in the mechanism",
    )


def test_an_error_beyond_the_tolerance_writes_nothing(train: Path) -> None:
    result = run(
        "reduce", train / "mechanism.yaml", "--tolerance", "0.001", "-o", train / "none.yaml"
    )
    assert result.code == 4
    # friction and inertia are the same everywhere, so that all runs have this error; the first of
    # them is named
    assert (
        "losses: in the run forward from -7, the step changes the position by 0.114 rad over a "
        "distance of 4.8 rad; allowed: 0.1 % of the distance" in result.stderr
    )
    assert not (train / "none.yaml").exists()


def test_a_link_that_yields_asks_for_a_bandwidth(tmp_path: Path) -> None:
    result = run("reduce", _write(tmp_path / "mechanism.yaml", belt()))
    assert result.code == 2
    assert (
        "compliant links (belt); give the frequency up to which their resonances matter, with "
        "--bandwidth RAD/S or --controller" in result.stderr
    )


def test_more_than_one_motion_or_command_is_refused_by_names(tmp_path: Path) -> None:
    whole = two_plays()
    loose = msgspec.structs.replace(
        whole,
        blocks={**whole.blocks, "flywheel": rotor(1e-3)},
        links={**whole.links, "pivot": coulomb("flywheel", 0.1)},
    )
    refused(
        run("reduce", _write(tmp_path / "loose.yaml", loose)),
        4,
        "flywheel does not move with motor",
    )
    sources = {**whole.sources, "second": motor("shaft")}
    control = Control("motor", "encoder")
    two = msgspec.structs.replace(whole, sources=sources, control=control)
    refused(run("reduce", _write(tmp_path / "two.yaml", two)), 4, "motor and second are commanded")
    unlimited = {"motor": Source("motor", "current", Q(0.05, unit="N m/A"))}
    endless = msgspec.structs.replace(whole, sources=unlimited)
    refused(
        run("reduce", _write(tmp_path / "endless.yaml", endless)), 4, "sources.motor.limit: missing"
    )


def test_a_differential_is_refused_with_both_ratios(tmp_path: Path) -> None:
    whole = two_plays()
    yielding = Coupling(
        ("motor", "shaft"), Compliance(Q(100.0, unit="N m/rad"), Q(0.1, unit="N m s/rad"))
    )
    crossed = msgspec.structs.replace(whole, links={**whole.links, "bypass": yielding})
    path = _write(tmp_path / "mechanism.yaml", crossed)
    refused(
        run("reduce", path, "--bandwidth", "100"),
        4,
        "links.bypass: paths from the source to shaft have different ratios: 1 through motor, "
        "-0.2 through gear",
    )


@pytest.mark.parametrize(("weight", "offset"), [(20.0, 0.2), (5.0, 0.0)])
def test_a_weight_is_an_offset_or_a_part_of_the_friction_that_holds_it(
    weight: float, offset: float, tmp_path: Path
) -> None:
    result = run(
        "reduce", _write(tmp_path / "mechanism.yaml", lift(weight)), "-o", tmp_path / "model.yaml"
    )
    assert result.code == 0, result.stderr
    model = load(tmp_path / "model.yaml", Model)
    assert model.parameters.offset.value == pytest.approx(offset, abs=1e-12)
    up = model.parameters.coulomb.value + offset
    backward = (
        model.laws.backward.coulomb
        if model.laws is not None and model.laws.backward is not None
        else model.parameters.coulomb
    )
    assert backward is not None
    down = backward.value - offset
    assert up == pytest.approx(0.01 * (8.0 + weight), rel=1e-9)
    assert down == pytest.approx(0.01 * (8.0 - weight), rel=1e-9)


def test_a_sensor_of_the_speed_is_no_models(tmp_path: Path) -> None:
    wide = msgspec.structs.replace(
        two_plays(), sensors={"speed": Sensor("motor", "velocity")}, travel=None
    )
    refused(
        run("reduce", _write(tmp_path / "mechanism.yaml", wide)),
        3,
        "sensors.speed.measures: found velocity; allowed: position",
    )


def test_end_stops_and_what_they_throw_back_are_those_of_the_model(tmp_path: Path) -> None:
    whole = lift(5.0)
    ends = Stop("table", Q(-0.2, unit="m"), Q(0.3, unit="m"), restitution=0.3)
    stopped = msgspec.structs.replace(whole, links={**whole.links, "ends": ends}, travel=None)
    result = run(
        "reduce", _write(tmp_path / "mechanism.yaml", stopped), "-o", tmp_path / "model.yaml"
    )
    assert result.code == 0, result.stderr
    model = load(tmp_path / "model.yaml", Model)
    assert model.bench.mechanics.travel is not None
    assert (model.bench.mechanics.travel.low, model.bench.mechanics.travel.high) == pytest.approx(
        (-20.0, 30.0), rel=1e-12
    )
    assert model.laws is not None
    assert model.laws.restitution == 0.3


def test_a_missing_file_is_told_in_the_words_of_every_command(tmp_path: Path, train: Path) -> None:
    refused(run("reduce", tmp_path / "nothere.yaml"), 3, "nothere.yaml: no such file")
    refused(
        run("reduce", train / "mechanism.yaml", "--controller", tmp_path / "nothere.yaml"),
        3,
        "nothere.yaml: no such file",
    )


def test_where_a_model_is_wanted_a_mechanism_is_to_be_reduced_first(train: Path) -> None:
    refused(
        run("validate", train / "mechanism.yaml", train / "log.mcap"),
        3,
        "reduce it first: frictool reduce",
    )


def test_a_travel_is_a_part_of_the_mechanisms_own(tmp_path: Path, train: Path) -> None:
    turned = run("reduce", train / "mechanism.yaml", "--travel", "3", "1")
    assert turned.code == 2
    assert "--travel: found 3 to 1; allowed: LOW < HIGH" in turned.stderr
    outside = run("reduce", train / "mechanism.yaml", "--travel", "11", "12")
    assert outside.code == 2
    assert (
        "--travel: found 11 to 12 rad; allowed: a part of -10 to 10 rad, the travel of built"
        in outside.stderr
    )
    assert (
        run(
            "reduce",
            train / "mechanism.yaml",
            "--travel",
            "-2",
            "20",
            "-o",
            tmp_path / "model.yaml",
        ).code
        == 0
    )
    model = load(tmp_path / "model.yaml", Model)
    assert model.bench.mechanics.travel is not None
    # the encoder counts down where the command is positive, and the model's position up
    assert (model.bench.mechanics.travel.low, model.bench.mechanics.travel.high) == (-10.0, 2.0)
    assert "--travel -2 20" in model.provenance.command
