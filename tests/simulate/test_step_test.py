"""The step test's log: what a bench would have logged, once for each variant, the same every
time."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.conditions import SensorFault
from frictool.documents.controller import Controller, StateSpace, Velocity
from frictool.documents.laws import Polynomial
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.errors import FrictoolError, InputFileError, NoSolutionError
from frictool.logs.log import Log
from frictool.report.verdict import judge
from frictool.simulate.axis_variants import variants_of
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from tests.support.provenance import HERE

STEP = 2 * math.pi / 56


def log_of(played: Scenario, model: Model | None = None, by: Controller | None = None) -> Log:
    return simulate_closed_loop(model or clutch_model(), by or controller(), played, HERE)


def test_nominal_is_one_stream_with_every_signal_in_si() -> None:
    stream = log_of(scenario()).main
    assert stream.units == {
        "position": "rad", "reference": "rad", "current": "A", "effort": "N m", "command": "A",
        "velocity": "rad/s", "position_true": "rad", "load_position": "rad", "current_true": "A",
    }  # fmt: skip
    np.testing.assert_allclose(stream.time, np.arange(1200) * 1e-3, rtol=1e-15)
    np.testing.assert_array_equal(stream.signals["reference"], np.repeat([40.0, 10.0], 600))
    np.testing.assert_allclose(
        stream.signals["effort"], 13.4e-3 * stream.signals["current"], rtol=1e-15
    )


def test_reaches_its_targets() -> None:
    position = log_of(scenario()).main.signals["position"]
    assert position[[599, 1199]] == pytest.approx([40.0, 10.0], abs=2.0 + STEP)


def test_the_encoder_reports_the_count_below() -> None:
    signals = log_of(scenario()).main.signals
    counts = signals["position"] / STEP
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    hidden = signals["position_true"] - signals["position"]
    assert hidden.min() >= -1e-12
    assert hidden.max() < STEP + 1e-12


def test_the_load_follows_within_the_backlash() -> None:
    signals = log_of(scenario()).main.signals
    gap = signals["position_true"] - signals["load_position"]
    assert gap[0] == 0.0
    assert np.max(np.abs(gap)) == pytest.approx(1.5)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_speed_above_the_top_speed_is_a_warning_of_simulation_and_report(share: float) -> None:
    by = controller()
    speed = max(
        float(np.abs(one.signals["velocity"]).max())
        for one in log_of(scenario(variants="vertices"), by=by).axes
    )
    mechanics = msgspec.structs.replace(
        by.bench.mechanics, top_speed=Quantity(value=share * speed, unit="rad/s")
    )
    by = msgspec.structs.replace(by, bench=msgspec.structs.replace(by.bench, mechanics=mechanics))
    log = log_of(scenario(variants="vertices"), by=by)
    remarks = judge(clutch_spec(modulus_margin=None), [log], bench=by.bench).remarks
    for lines in (log.warnings, remarks):
        found = [line for line in lines if "above mechanics.top_speed" in line]
        assert len(found) == (share < 1.0)
        assert all(f"reaches {speed:.4g} rad/s" in line for line in found)
    assert not judge(clutch_spec(modulus_margin=None), [log]).remarks


def test_vertices_are_streams_of_their_own_with_their_own_plant() -> None:
    log = log_of(scenario(variants="vertices"))
    assert [stream.topic for stream in log.streams] == [
        "/axis",
        *(f"/axis/v{k:02d}" for k in range(1, 17)),
    ]
    nominal, *others = (stream.signals["velocity"] for stream in log.streams)
    assert len({array.tobytes() for array in (nominal, *others)}) == 17
    np.testing.assert_array_equal(log_of(scenario()).main.signals["velocity"], nominal)
    plants = [
        variant.axis for variant in variants_of(clutch_model(), scenario(variants="vertices"))
    ]
    assert [plant.inertia for plant in plants] == [1.32e-5, *[1.11e-5] * 8, *[1.53e-5] * 8]
    assert [plant.coulomb for plant in plants] == [0.099, *[0.018, 0.018, 0.18, 0.18] * 4]
    assert plants[3].breakaway == pytest.approx(0.198)


def test_vertices_are_those_of_the_model_whatever_the_controller_was_verified_for() -> None:
    """The hull of the model's interval and of the bench's range: a model that is lighter than its
    bench says is played so light."""
    model = clutch_model()
    inertia = msgspec.structs.replace(model.parameters.inertia, value=5e-6, low=4.9e-6, high=5.1e-6)
    light = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, inertia=inertia)
    )
    plants = [variant.axis.inertia for variant in variants_of(light, scenario(variants="vertices"))]
    assert plants == [5e-6, *[4.9e-6] * 8, *[1.53e-5] * 8]
    log = log_of(scenario(), light)
    assert log.warnings == (
        "model is outside the range for which controller was verified: inertia 4.9e-06 to "
        "1.53e-05 kg m^2, verified 1.11e-05 to 1.53e-05; the margins do not apply: run frictool "
        "synth again",
    )


def test_noise_is_seeded_and_independent_between_variants() -> None:
    quiet = log_of(scenario(variants="vertices"))
    loud, again, other = (
        log_of(scenario(variants="vertices", drive_noise=0.2, seed=seed)) for seed in (7, 7, 8)
    )
    noises = []
    for silent, noisy, same, differing in zip(
        quiet.streams, loud.streams, again.streams, other.streams, strict=True
    ):
        noise = noisy.signals["current"] - silent.signals["current"]
        assert np.std(noise) == pytest.approx(0.2, rel=0.1)
        np.testing.assert_array_equal(noisy.signals["current"], same.signals["current"])
        assert not np.array_equal(noisy.signals["current"], differing.signals["current"])
        np.testing.assert_array_equal(noisy.signals["position"], silent.signals["position"])
        noises.append(noise)
    assert np.max(np.abs(np.corrcoef(noises) - np.eye(17))) < 0.15


def test_metadata_says_simulated_and_from_what() -> None:
    metadata = log_of(scenario()).metadata
    assert metadata["log"] == {
        "kind": "simulated",
        "scenario": "steps",
        "model": "clutch",
        "controller": "speed",
    }
    assert metadata["provenance"] == {
        "command": "frictool simulate",
        "frictool": "0",
        "input_1": "model.yaml sha256:" + "ab" * 32,
    }


def test_a_measured_speed_is_in_the_log_and_in_the_loop() -> None:
    """A speed sensor gives the true speed; the controller is the one that differences the
    encoder."""
    by = controller()
    law = msgspec.structs.replace(by.position_law, action="brake", rest_speed=40.0)
    by = msgspec.structs.replace(by, position_law=law)
    sensed = msgspec.structs.replace(by, velocity=Velocity(source="measured"))
    logs = [log_of(scenario(), by=one).main for one in (by, sensed)]
    assert "velocity_measured" not in logs[0].signals
    np.testing.assert_array_equal(logs[1].signals["velocity_measured"], logs[1].signals["velocity"])
    assert logs[1].units["velocity_measured"] == "rad/s"
    assert not np.array_equal(logs[0].signals["position_true"], logs[1].signals["position_true"])


def test_a_wrong_current_moves_otherwise_than_a_sound_one() -> None:
    faults = (
        SensorFault("drive_offset", 0.1, offset=Quantity(value=3.0, unit="A")),
        SensorFault("drive_gain", 0.2, gain_error=0.2),
    )
    sound, wrong = log_of(scenario()).main, log_of(scenario(sensor_faults=faults)).main
    shown, true = wrong.signals["current"], wrong.signals["current_true"]
    np.testing.assert_array_equal(shown[:100], true[:100])
    np.testing.assert_allclose(shown[200:], 1.2 * true[200:] + 3.0, rtol=1e-12)
    np.testing.assert_allclose(
        wrong.signals["effort"], 13.4e-3 * shown, rtol=1e-15
    )  # as the bench computes it
    np.testing.assert_array_equal(sound.signals["current"], sound.signals["current_true"])
    assert not np.array_equal(sound.signals["position_true"], wrong.signals["position_true"])


def test_the_knee_and_the_backlash_of_the_published_clutch_are_played() -> None:
    """Without the knee's viscous friction it goes faster, once it is above it and not before; the
    load is within half a backlash."""
    model = load(ROOT / "configs/clutch/nonlinear.yaml", Model)
    bare = msgspec.structs.replace(model, laws=msgspec.structs.replace(model.laws, regimes=()))
    far = msgspec.structs.replace(controller(), prefilter=None)
    kneed, free = (log_of(scenario(60.0, 5.0), plant, far).main.signals for plant in (model, bare))
    first = int(np.flatnonzero(np.abs(kneed["velocity"]) > 260.0)[0])
    np.testing.assert_array_equal(kneed["position_true"][:first], free["position_true"][:first])
    assert np.max(np.abs(free["velocity"])) > np.max(np.abs(kneed["velocity"])) + 1.0
    gap = kneed["position_true"] - kneed["load_position"]
    assert np.max(np.abs(gap)) == pytest.approx(1.5)


def test_progress_counts_the_variants_batch_by_batch() -> None:
    seen: list[tuple[int, int]] = []
    long = scenario(seconds=70.0, variants="random", plants=6)
    simulate_closed_loop(
        clutch_model(), controller(), long, HERE, progress=lambda *done: seen.append(done)
    )
    assert seen == [(0, 7), (4, 7), (7, 7)]


def _with_travel(low: float, high: float) -> Model:
    model = clutch_model()
    mechanics = msgspec.structs.replace(model.bench.mechanics, travel=Span(low, high, "rad"))
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics)
    )


def test_an_end_stop_holds_the_axis_and_is_a_warning() -> None:
    inside = simulate_closed_loop(_with_travel(0.0, 63.0), controller(), scenario(), HERE)
    assert inside.warnings == ()
    assert float(np.max(inside.main.signals["position_true"])) > 40.0
    stopped = simulate_closed_loop(_with_travel(0.0, 40.0), controller(), scenario(), HERE)
    position = stopped.main.signals["position_true"]
    assert position.max() == 40.0
    arrival = stopped.main.time[int(np.argmax(position))]
    (warning,) = stopped.warnings
    assert warning == f"/axis runs against its end stop at 40 rad, first at {arrival:.3f} s"


@pytest.mark.parametrize(
    ("played", "by", "words"),
    [
        (
            scenario(),
            msgspec.structs.replace(controller(), delay_samples=0),
            "controller: delay_samples: found 0, .* has 1",
        ),
        (
            scenario(),
            msgspec.structs.replace(controller(), sample_period_s=2e-3),
            "controller: sample_period_s: found 0.002",
        ),
        (
            scenario(),
            msgspec.structs.replace(controller(), drive="voltage"),
            "controller: drive: found voltage",
        ),
        (
            scenario(),
            msgspec.structs.replace(controller(), axis="linear"),
            "controller: axis: found linear",
        ),
        (
            msgspec.structs.replace(scenario(), axis="linear"),
            controller(),
            "scenario: axis: found linear",
        ),
        (
            scenario(40.0, 63.5),
            controller(),
            r"scenario: steps\[1\].reference: found 63.5 rad; allowed: .* 0 to 63 rad",
        ),
        (scenario(start=-1.0), controller(), "scenario: start: found -1 rad"),
        (scenario(seconds=4e-4), controller(), r"scenario: steps\[0\].duration_s: found 0.0004"),
        (scenario(seconds=1e9), controller(), r"scenario: steps: requests 2e\+12 samples"),
    ],
)
def test_what_does_not_fit_together_is_refused(
    played: Scenario, by: Controller, words: str
) -> None:
    with pytest.raises(InputFileError, match=words):
        log_of(played, by=by)


def test_friction_that_cannot_be_is_refused_with_its_place() -> None:
    model = load(ROOT / "configs/clutch/nonlinear.yaml", Model)
    rising = msgspec.structs.replace(model.laws.position, breakaway=Polynomial((1.0, 0.1)))
    with pytest.raises(
        FrictoolError,
        match=r"model: position: breakaway minus Coulomb friction backward is -0.* at 0; allowed: "
        r">= 0",
    ):
        log_of(
            scenario(),
            msgspec.structs.replace(
                model, laws=msgspec.structs.replace(model.laws, position=rising)
            ),
        )


def test_the_published_clutch_differs_from_its_mean() -> None:
    """The same controller, the same steps: friction that depends on position and direction moves
    the encoder otherwise, and it rests."""
    model = load(ROOT / "configs/clutch/nonlinear.yaml", Model)
    flat = msgspec.structs.replace(model, laws=None)
    logs = [log_of(scenario(seconds=1.5), plant) for plant in (model, flat)]
    positions = [log.main.signals["position_true"] for log in logs]
    assert np.max(np.abs(positions[0] - positions[1])) > 0.1
    for log in logs:
        assert log.main.signals["velocity"][-1] == 0.0
        assert abs(log.main.signals["position_true"][-1] - 10.0) < 2.5


def test_a_loop_that_leaves_the_floating_point_numbers_is_no_result() -> None:
    """Both states of the controller grow tenfold a sample and cancel in the drive, until inf - inf
    does not."""
    system = StateSpace(
        a=((10.0, 0.0), (0.0, 10.0)), b=((1.0,), (1.0,)), c=((1.0, -1.0),), d=((0.0,),)
    )
    speed = msgspec.structs.replace(controller().linear, discrete=system)
    with pytest.raises(NoSolutionError, match=r"/axis: .*floating-point"):
        log_of(scenario(), by=msgspec.structs.replace(controller(), linear=speed))


def test_a_voltage_drive_of_a_linear_axis() -> None:
    """EMPS: no lag, so that the voltage at a sample is what acts from it on."""
    bench = load(ROOT / "configs/emps/bench.yaml", Bench)
    n = {"source": "bench", "low": 0.0, "high": 300.0}
    parameters = msgspec.structs.replace(
        clutch_model().parameters,
        inertia=Estimate(value=95.0, unit="kg", **n),
        viscous=Estimate(value=200.0, unit="N s/m", **n),
        coulomb=Estimate(value=20.0, unit="N", **n),
        breakaway=Estimate(value=25.0, unit="N", **n),
        offset=Estimate(value=-3.0, unit="N", **n),
    )
    model = msgspec.structs.replace(
        clutch_model(), axis="linear", bench=bench, parameters=parameters
    )
    law = msgspec.structs.replace(
        controller().position_law, gain=0.6, band=1e-3, settled_speed=1e-3
    )
    gains = msgspec.structs.replace(controller().linear, anti_windup=(0.0, 0.0))
    scale = 95.0 / 1.32e-5 * 13.4e-3 / 35.15
    out = tuple(tuple(scale * value for value in row) for row in gains.discrete.c)
    direct = tuple(tuple(scale * value for value in row) for row in gains.discrete.d)
    gains = msgspec.structs.replace(
        gains, discrete=msgspec.structs.replace(gains.discrete, c=out, d=direct)
    )
    by = msgspec.structs.replace(
        controller(),
        axis="linear",
        drive="voltage",
        drive_limit=10.0,
        bench=bench,
        position_law=law,
        linear=gains,
    )
    played = Scenario(
        format="scenario/1",
        name="steps",
        axis="linear",
        start=Quantity(value=0.05, unit="m"),
        steps=(Step(Quantity(value=0.1, unit="m"), 1.0),),
    )
    stream = log_of(played, model, by).main
    assert (stream.units["position"], stream.units["voltage"], stream.units["effort"]) == (
        "m",
        "V",
        "N",
    )
    np.testing.assert_array_equal(
        stream.signals["voltage"][1:], stream.signals["command"][:-1]
    )  # one sample of delay
    assert stream.signals["position_true"][-1] == pytest.approx(0.1, abs=2e-3)
    fault = SensorFault("drive_offset", 0.0, offset=Quantity(value=0.5, unit="V"))
    with pytest.raises(
        InputFileError, match="scenario: drive: found current; allowed: voltage, the drive of"
    ):
        log_of(msgspec.structs.replace(played, sensor_faults=(fault,)), model, by)
    wrong = log_of(
        msgspec.structs.replace(played, sensor_faults=(fault,), drive="voltage"), model, by
    ).main
    np.testing.assert_array_equal(
        wrong.signals["voltage"], stream.signals["voltage"] + 0.5
    )  # a voltage is not fed back
    np.testing.assert_array_equal(wrong.signals["position_true"], stream.signals["position_true"])
