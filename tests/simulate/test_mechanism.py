"""A mechanism under its controller: one block moves as the axis that it is, and the log tells all
blocks of a longer chain."""

from __future__ import annotations

import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.bench import Bench, Winding
from frictool.documents.conditions import Disturbance, DriftPoint, Drifts, SensorFault, Signal
from frictool.documents.controller import StateSpace
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.engine.axis_motion import advance
from frictool.errors import DocumentError, FrictoolError, InputFileError, NoSolutionError
from frictool.logs.log import Log
from frictool.plant.axis import POSITION, VELOCITY, AxisParameters, rest
from frictool.simulate.closed_loop import SimulationRequest, simulate_closed_loop
from frictool.simulate.compiled_target import COMPILERS, compiled_target
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.open_loop import simulate_open_loop
from studies.rigs.clutch_model import ROOT
from studies.rigs.step_scenario import controller, scenario
from tests.support.compiled_c import sources
from tests.support.mechanism_text import mechanism
from tests.support.provenance import HERE
from tests.support.simulated_mechanisms import GEARED, ONE_BLOCK, clutch, one_axis, plant_of

AXIS = {
    "position_true",
    "velocity",
    "load_position",
    "current_true",
    "command",
    "position",
    "current",
    "effort",
}


def torque(value: float) -> Quantity:
    return Quantity(value=value, unit="N m")


def log_of(text: str, played: Scenario | None = None) -> Log:
    return simulate_closed_loop(plant_of(text), controller(), played or scenario(), HERE)


def compared(played: Scenario) -> tuple[Log, Log]:
    return simulate_closed_loop(
        plant_of(ONE_BLOCK), controller(), played, HERE
    ), simulate_closed_loop(one_axis(), controller(), played, HERE)


def same(ours: Log, theirs: Log) -> None:
    """Counts and references agree exactly, what they are made of to the tolerance of the
    integration."""
    assert set(theirs.main.signals) == set(ours.main.signals)
    assert ours.main.units == theirs.main.units
    for name in ("position", "reference"):
        np.testing.assert_allclose(ours.main.signals[name], theirs.main.signals[name], atol=1e-9)
    for name in (
        "position_true",
        "velocity",
        "load_position",
        "current_true",
        "command",
        "current",
        "effort",
    ):
        np.testing.assert_allclose(
            ours.main.signals[name], theirs.main.signals[name], atol=2e-5, rtol=1e-7, err_msg=name
        )


def test_one_block_moves_as_the_axis_that_it_is() -> None:
    """Another engine, in closed form: stick, breakaway, lag, encoder, delay, noise are the same."""
    ours, theirs = compared(scenario(drive_noise=0.1, seed=3))
    same(ours, theirs)
    assert np.max(np.abs(theirs.main.signals["velocity"])) > 100.0
    np.testing.assert_array_equal(
        ours.main.signals["velocity"] == 0.0, theirs.main.signals["velocity"] == 0.0
    )


def test_what_happens_to_one_block_is_what_happens_to_the_axis() -> None:
    played = scenario(
        disturbances=(
            Disturbance("pulse", torque(-0.3), 0.3, 0.02),
            Disturbance("step", torque(0.02), 0.8),
        ),
        drifts=Drifts(
            friction=(DriftPoint(0.0, 1.0), DriftPoint(1.0, 1.4)),
            viscous=(DriftPoint(0.0, 0.9),),
            constant=(DriftPoint(0.0, 1.0), DriftPoint(1.2, 0.9)),
        ),
        sensor_faults=(
            SensorFault("lost_counts", 0.7, counts=3),
            SensorFault("encoder_stuck", 0.62, until_s=0.64),
            SensorFault("encoder_invalid", 0.1, until_s=0.103),
            SensorFault("encoder_invalid", 1.15),
            SensorFault("drive_offset", 0.9, offset=Quantity(value=0.5, unit="A")),
            SensorFault("drive_gain", 1.0, gain_error=0.1),
        ),
    )
    ours, theirs = compared(played)
    same(ours, theirs)
    quiet, _ = compared(scenario())
    assert (
        np.max(np.abs(ours.main.signals["position_true"] - quiet.main.signals["position_true"]))
        > 1.0
    )


def test_a_winding_limits_the_block_as_it_limits_the_axis() -> None:
    """The supply is too small for the controller's current at speed: both are slowed alike."""
    text = ONE_BLOCK.replace(
        "loop_time_constant_s: 0.003}",
        "loop_time_constant_s: 0.003, winding: {resistance_ohm: 0.3, voltage_v: 5}}",
    )
    model = one_axis()
    actuator = msgspec.structs.replace(model.bench.actuator, winding=Winding(0.3, 5.0))
    model = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, actuator=actuator)
    )
    ours, theirs = (
        simulate_closed_loop(plant_of(text), controller(), scenario(), HERE),
        simulate_closed_loop(model, controller(), scenario(), HERE),
    )
    same(ours, theirs)
    free = log_of(ONE_BLOCK).main.signals["velocity"]
    assert np.max(np.abs(ours.main.signals["velocity"])) < np.max(np.abs(free)) - 1.0


def test_a_voltage_on_a_sledge() -> None:
    """No lag, the drive on a block that slides: EMPS's numbers, and a weight as a constant effort
    in place of its offset."""
    bench = load(ROOT / "configs/emps/bench.yaml", Bench)
    text = f"""\
format: mechanism/1
name: sledge
sample_period_s: {bench.sample_period_s}
delay_samples: {bench.delay_samples}
blocks:
  sledge: {{mass: {{value: 95, unit: kg}}}}
links:
  way:
    kind: friction
    on: sledge
    law: svc
    parameters: {{coulomb: {{value: 20, unit: N}}, breakaway: {{value: 25, unit: N}},
      viscous: {{value: 200, unit: N s/m}}}}
sources:
  motor: {{on: sledge, drive: voltage, constant: {{value: 35.15, unit: N/V}}, limit: {{value: 10,
    unit: V}}}}
  weight: {{on: sledge, drive: effort, effort: {{value: 3, unit: N}}}}
sensors:
  scale: {{on: sledge, step: {{value: {bench.encoder.resolution!r}, unit: m}}}}
"""
    sources = {"motor": (Signal("step", Quantity(value=2.0, unit="V"), 0.01),)}
    played = Scenario(
        format="scenario/1",
        name="push",
        axis="linear",
        sources=sources,
        duration_s=0.3,
        drive="voltage",
        drive_noise=0.01,
    )
    document = mechanism(text)
    log = simulate_open_loop(document, assemble(document), played, HERE, DocumentNames())
    axis = AxisParameters(95.0, 200.0, 20.0, 25.0, -3.0, 35.15, drive_limit=10.0)
    state, expected = rest(), []
    for k in range(log.main.time.size):
        expected.append((state[POSITION], state[VELOCITY]))
        assert (
            advance(
                state,
                2.0 if log.main.time[k] > 0.0099 else 0.0,
                axis.as_array(),
                bench.sample_period_s,
            )
            == 0
        )
    found = log.main.signals
    np.testing.assert_allclose(found["position_true"], [one for one, _ in expected], atol=1e-9)
    np.testing.assert_allclose(found["velocity"], [one for _, one in expected], atol=1e-8)
    assert {name: log.main.units[name] for name in ("voltage", "effort", "position")} == {
        "voltage": "V",
        "effort": "N",
        "position": "m",
    }
    np.testing.assert_allclose(found["voltage_true"][-1], 2.0)


def test_a_disturbance_begins_at_its_instant_and_not_at_a_sample() -> None:
    """While the block slips it gains a t^2/2 in the half sample that is left; the mean over the
    sample would give it twice that."""
    push = (Disturbance("pulse", torque(-0.4), 0.0505, 0.001),)
    pushed, free = (
        log_of(ONE_BLOCK, scenario(60.0, disturbances=one, seconds=0.06)).main.signals
        for one in (push, ())
    )
    gained = free["position_true"][51] - pushed["position_true"][51]
    assert gained == pytest.approx(0.5 * 0.4 / 1.32e-5 * 5e-4**2, rel=0.02)
    assert pushed["disturbance"][49:53] == pytest.approx([0.0, -0.2, -0.2, 0.0])


def test_the_log_of_a_chain() -> None:
    log = log_of(GEARED)
    assert [stream.topic for stream in log.streams] == ["/axis", "/mechanism"]
    axis, blocks = (stream.signals for stream in log.streams)
    assert set(axis) > AXIS
    assert log.streams[1].units == {
        "rotor_position": "rad", "rotor_velocity": "rad/s", "rotor_stuck": "1",
        "load_position": "rad", "load_velocity": "rad/s", "load_stuck": "1",
        "pair_contact": "1", "motor_current": "A", "hand_effort": "N m", "encoder_position": "rad",
        "dial_position": "rad",
    }  # fmt: skip
    np.testing.assert_array_equal(axis["position_true"], blocks["rotor_position"])
    np.testing.assert_array_equal(axis["position"], blocks["encoder_position"])
    np.testing.assert_array_equal(axis["current_true"], blocks["motor_current"])
    np.testing.assert_allclose(
        axis["load_position"], 5.0 - 2.0 * (blocks["load_position"] + 2.5), rtol=1e-12, atol=1e-12
    )
    gap = axis["position_true"] - axis["load_position"]
    assert np.max(np.abs(gap)) == pytest.approx(0.5, abs=1e-9)
    np.testing.assert_allclose(np.abs(gap[blocks["pair_contact"] != 0.0]), 0.5, atol=1e-9)
    assert np.all(blocks["rotor_velocity"][blocks["rotor_stuck"] == 1.0] == 0.0)
    assert {*np.unique(blocks["rotor_stuck"])} == {0.0, 1.0}
    assert float(np.abs(axis["position"][-1] - 10.0)) < 2.2


def test_energy_goes_somewhere_and_events_are_counted() -> None:
    log = log_of(GEARED)
    energy = {name: float(value) for name, value in log.metadata["energy/mechanism"].items()}
    assert energy["input"] > 1.0
    assert abs(energy["residual"]) < 1e-6 * energy["input"]
    lost = sum(value for name, value in energy.items() if name.startswith("lost in "))
    assert lost + energy["kinetic"] + energy["stored"] + energy["residual"] == pytest.approx(
        energy["input"], rel=1e-12
    )
    events = {name: int(value) for name, value in log.metadata["events/mechanism"].items()}
    assert events["rotor breaks away"] >= 2
    assert events["pair touches"] >= 2


def test_the_start_moves_all_that_hangs_on_the_sensor() -> None:
    log = simulate_closed_loop(
        clutch(), controller(), scenario(30.0, start=20.0, seconds=0.3), HERE
    )
    blocks = log.streams[1].signals
    assert blocks["rotor_position"][0] == 20.0
    assert blocks["cart_position"][0] == pytest.approx(20.0 * 0.20414e-3, rel=1e-12)
    assert blocks["slave_position"][0] == pytest.approx(
        20.0 * 0.20414e-3 * 285.0 / 475.0, rel=1e-12
    )
    assert log.main.signals["load_position"][0] == pytest.approx(20.0, rel=1e-12)
    with pytest.raises(
        InputFileError,
        match=r"scenario: start: puts cart at 0.0142898 m; allowed: 0 to 0.0128608 m, the stops "
        r"of ends",
    ):
        simulate_closed_loop(clutch(), controller(), scenario(30.0, start=70.0), HERE)


def test_drawn_mechanisms_are_the_same_however_many_there_are() -> None:
    many = log_of(GEARED, scenario(30.0, seconds=0.2, variants="random", plants=4, seed=5))
    few = log_of(GEARED, scenario(30.0, seconds=0.2, variants="random", plants=2, seed=5))
    assert [stream.topic for stream in few.streams] == [
        "/axis",
        "/mechanism",
        "/axis/p1",
        "/mechanism/p1",
        "/axis/p2",
        "/mechanism/p2",
    ]
    for one, other in zip(few.streams, many.streams, strict=False):
        for name, values in one.signals.items():
            np.testing.assert_array_equal(values, other.signals[name])
    moved = [stream.signals["position_true"] for stream in many.axes]
    assert len({array.tobytes() for array in moved}) == 5
    for text in many.metadata["plants"].values():
        drawn = {
            key: float(value) for key, value, *_ in (part.split(" ") for part in text.split(", "))
        }
        assert set(drawn) == {
            "blocks.rotor.inertia",
            "links.bearing.parameters.coulomb",
            "links.bearing.parameters.breakaway",
        }
        assert 1.1e-5 <= drawn["blocks.rotor.inertia"] <= 1.3e-5
        assert 0.03 <= drawn["links.bearing.parameters.coulomb"] <= 0.05


def test_no_breakaway_is_drawn_below_its_coulomb_friction() -> None:
    """And it is drawn from what lies above, not cut: none is equal."""
    drawn = plant_of(GEARED).variants(
        controller(), scenario(variants="random", plants=200, seed=1), "geared"
    )[1:]
    pairs = [
        [one.values[f"links.bearing.parameters.{name}"] for name in ("coulomb", "breakaway")]
        for one in drawn
    ]
    assert all(max(coulomb, 0.032) < breakaway <= 0.052 for coulomb, breakaway in pairs)
    assert max(coulomb for coulomb, _ in pairs) > 0.0495
    known = GEARED.replace(
        "{value: 0.044, low: 0.032, high: 0.052, unit: N m}", "{value: 44, unit: mN m}"
    )
    for one in plant_of(known).variants(
        controller(), scenario(variants="random", plants=5, seed=1), "geared"
    )[1:]:  # without a range: a multiple
        parameters = one.document.links["bearing"].parameters
        assert parameters["breakaway"].value == pytest.approx(1100.0 * parameters["coulomb"].value)
    too_low = GEARED.replace("high: 0.052", "high: 0.045")
    with pytest.raises(
        DocumentError,
        match=r"bearing.parameters.breakaway: found 0.032 to 0.045 N m, below .*coulomb of up to "
        r"0.05 N m",
    ):
        log_of(too_low, scenario(variants="random", plants=2))


def test_without_ranges_there_is_nothing_to_draw() -> None:
    with pytest.raises(
        FrictoolError, match="model: variants: random needs ranges, but no quantity has one"
    ):
        log_of(ONE_BLOCK, scenario(variants="random", plants=2))


@pytest.mark.skipif(not any(map(shutil.which, COMPILERS)), reason="no C compiler on the PATH")
def test_the_exported_code_in_the_loop_gives_the_same_log(tmp_path: Path) -> None:
    for name, text in sources(controller(), "double").items():
        (tmp_path / name).write_text(text)
    code = compiled_target(
        tmp_path, "0" * 64, "controller.yaml", tuple(controller_program(controller()).inputs)
    )
    played = (
        plant_of(GEARED),
        controller(),
        scenario(40.0, 25.0, seconds=0.2, drive_noise=0.05),
        HERE,
    )
    ours, theirs = (
        simulate_closed_loop(*played),
        simulate_closed_loop(*played, request=SimulationRequest(target=code)),
    )
    for one, other in zip(ours.streams, theirs.streams, strict=True):
        for name, values in one.signals.items():
            np.testing.assert_array_equal(values, other.signals[name], err_msg=name)


def test_a_source_beside_the_controllers() -> None:
    """A hand on the load takes it through the backlash and the gear: the controller has to push
    back."""
    held = scenario(30.0, seconds=0.4, sources={"hand": (Signal("step", torque(0.3), 0.2),)})
    pushed, free = (log_of(GEARED, one) for one in (held, scenario(30.0, seconds=0.4)))
    np.testing.assert_array_equal(pushed.streams[1].signals["hand_effort"][200:], 0.3)
    first = int(
        np.flatnonzero(
            pushed.streams[1].signals["load_position"] != free.streams[1].signals["load_position"]
        )[0]
    )
    assert first == 201
    assert float(pushed.metadata["energy/mechanism"]["residual"]) < 1e-6


def test_a_loop_that_leaves_the_floating_point_numbers_tells_when() -> None:
    system = StateSpace(
        a=((10.0, 0.0), (0.0, 10.0)), b=((1.0,), (1.0,)), c=((1.0, -1.0),), d=((0.0,),)
    )
    broken = msgspec.structs.replace(
        controller(), linear=msgspec.structs.replace(controller().linear, discrete=system)
    )
    with pytest.raises(
        NoSolutionError,
        match=r"/axis: at 0\.\d+ s the simulation left the range of floating-point numbers",
    ):
        simulate_closed_loop(plant_of(GEARED), broken, scenario(), HERE)
