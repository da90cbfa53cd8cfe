"""A model's load at synthesis and in simulation: bounded disturbances are told, a load without a
bound or beyond the drive is refused, nothing is passed over in silence."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.axis_model import load_of
from frictool.documents.laws import Gravity, Laws, Load, Ripple, TotalLoad
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity, Span
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.logs.log import Log
from frictool.plant.position_load import load_effort
from frictool.simulate.axis_variants import parameters_of
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.synth.load_disturbance import amplitude, disturbance
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_scenario import controller, scenario
from tests.support.command_line import refused
from tests.support.provenance import HERE
from tests.support.sprung_valve import positioner, valve

CLUTCH = ROOT / "configs" / "clutch"


def near(value: float, half: float = 0.001, unit: str = "N m") -> Estimate:
    return Estimate(value, value - half, value + half, unit, source="identified")


def loaded(**load: object) -> Model:
    return msgspec.structs.replace(clutch_model(), laws=Laws(load=Load(**load)))


RIPPLE = Ripple(7.0, Quantity(2.0 * math.pi, unit="rad"), near(0.01), near(-0.02))


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 1.0), st.floats(-10.0, 10.0))
def test_an_amplitude_bounds_its_harmonic(
    sine: float, cosine: float, half: float, angle: float
) -> None:
    bound = amplitude(near(sine, half), near(cosine, half))
    for a in (sine - half, sine, sine + half):
        for b in (cosine - half, cosine, cosine + half):
            assert abs(a * math.sin(angle) + b * math.cos(angle)) <= bound * (1.0 + 1e-12) + 1e-15


def test_the_sum_of_what_acts() -> None:
    model = loaded(gravity=Gravity(near(0.03), near(0.04)), ripple=RIPPLE)
    model = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, offset=near(-0.005))
    )
    found = disturbance(model)
    assert found.total == pytest.approx(0.006 + math.hypot(0.031, 0.041) + math.hypot(0.011, 0.021))
    assert found.available == pytest.approx(12.8e-3 * model.bench.actuator.limit.value)


def test_offset_and_load_are_bounded_together_where_the_model_states_it() -> None:
    """The bound of the total is used if it is smaller and describes this model and its travel."""
    gravity = Gravity(near(0.03, 0.02), near(0.04, 0.02))
    span = Span(-1.0, 1.0, "rad")
    total = TotalLoad(near(-0.003), near(0.05), Quantity(0.002, unit="N m"), span)
    travel = Span(-0.9, 0.9, "rad")
    plain = loaded(gravity=gravity, total=total)
    mechanics = msgspec.structs.replace(plain.bench.mechanics, travel=travel)
    model = msgspec.structs.replace(
        plain, bench=msgspec.structs.replace(plain.bench, mechanics=mechanics)
    )
    offset = {"offset": near(0.0, 0.03)}
    parameters = msgspec.structs.replace(model.parameters, **offset)
    model = msgspec.structs.replace(model, parameters=parameters)
    assert disturbance(model).total == pytest.approx(0.051)
    assert parameters_of(model)["offset"].high == pytest.approx(0.002)
    longer = msgspec.structs.replace(mechanics, travel=Span(-0.9, 1.2, "rad"))
    edited = msgspec.structs.replace(parameters, offset=near(0.05, 0.03))
    for other in (
        msgspec.structs.replace(
            model, bench=msgspec.structs.replace(model.bench, mechanics=longer)
        ),
        msgspec.structs.replace(model, parameters=edited),
    ):
        assert disturbance(other).together is None
        assert disturbance(other).total > 0.1


def test_a_load_that_the_drive_cannot_bear_is_refused() -> None:
    with pytest.raises(NoSolutionError, match=r"exceed the actuator's \S+ N m; .* raise actuator"):
        disturbance(loaded(gravity=Gravity(near(5.0), near(0.0))))


@given(st.floats(-100.0, 100.0))
def test_the_harmonics_of_the_document_are_those_of_the_plant(x: float) -> None:
    load = load_of(
        loaded(
            stiffness=near(0.02, unit="N m/rad"),
            gravity=Gravity(near(0.1), near(-0.2)),
            ripple=RIPPLE,
        )
    )
    expected = (
        0.02 * x
        + 0.1 * math.sin(x)
        - 0.2 * math.cos(x)
        + 0.01 * math.sin(7.0 * x)
        - 0.02 * math.cos(7.0 * x)
    )
    assert load_effort(load.as_array(), x) == pytest.approx(expected, abs=1e-9)
    assert load.at(np.array([x]))[0] == pytest.approx(expected, abs=1e-9)


def synth(folder: Path, model: Model, *options: str) -> object:
    path = folder / "model.yaml"
    path.write_text(to_yaml(model))
    design = sorted((CLUTCH / "designs").glob("*.yaml"))[0]
    return run(
        "synth",
        path,
        "--spec",
        CLUTCH / "spec.yaml",
        "--design",
        design,
        "--vertices-only",
        "--no-play",
        *options,
    )


@given(
    st.floats(0.0, 5.0),
    st.floats(0.0, 1.0),
    st.floats(-3.0, 3.0),
    st.floats(0.0, 0.5),
    st.floats(0.0, 1.6),
)
def test_spring_and_offset_are_bounded_together_on_the_travel(
    stiffness: float, wide: float, offset: float, half: float, position: float
) -> None:
    """Also if the offset puts the rest position of the spring inside the travel, or beyond it."""
    model = valve(stiffness - min(wide, stiffness), stiffness, stiffness + wide)
    model = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, offset=near(offset, half))
    )
    load = disturbance(model)
    assert load.offset == 0.0
    assert load.total == load.spring
    for slope in (stiffness - min(wide, stiffness), stiffness + wide):
        for constant in (offset - half, offset + half):
            assert abs(slope * position + constant) <= load.spring * (1.0 + 1e-12) + 1e-12
    steepest = stiffness + wide
    assert load.spring == pytest.approx(
        max(abs(offset) + half, abs(offset + 1.6 * steepest) + half)
    )


def test_a_spring_relaxed_in_the_travel_counts_from_there() -> None:
    """The zero of an encoder is anywhere: -0.7 N m + 0.88 N m/rad x is 0 at x = 0.8 rad."""
    model = valve(0.88, 0.88, 0.88)
    offset = near(-0.88 * 0.8, 0.0)
    model = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, offset=offset)
    )
    assert disturbance(model).total == pytest.approx(0.88 * 0.8)


def test_a_spring_without_a_travel_has_no_bound() -> None:
    with pytest.raises(
        NoSolutionError, match=r"0\.88 N m/rad: without a travel.*mechanics\.travel"
    ):
        disturbance(valve(0.84, 0.88, 0.92, travel=False))


def test_a_spring_that_drives_the_axis_away_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="negative stiffness drives the axis away"):
        disturbance(valve(-0.92, -0.88, -0.84))


def test_a_spring_beyond_the_drive_is_refused() -> None:
    """32 N m at the limit, less 9.3 N m of Coulomb friction, leave 22.7 N m for the load."""
    assert disturbance(valve(13.9, 13.9, 13.9)).total == pytest.approx(0.3 + 1.6 * 13.9)
    with pytest.raises(NoSolutionError, match=r"load \(22\.86\) and Coulomb friction \(9\.3\)"):
        disturbance(valve(13.9, 13.9, 14.1))


def ends_of_steps(model: Model) -> dict[float, tuple[float, float]]:
    """Return error and motion [rad] in the last 2 s of each step, by its reference [rad]."""
    targets = (0.9, 0.3, 1.5)
    steps = scenario(*targets, seconds=4.0, start=0.6)
    log = simulate_closed_loop(model, positioner(model), steps, HERE)
    ends = position_of(log).reshape(len(targets), -1)[:, -1000:]
    return {
        target: (float(np.max(np.abs(end - target))), float(np.ptp(end)))
        for target, end in zip(targets, ends, strict=True)
    }


def test_a_spring_below_the_breakaway_leaves_the_axis_at_rest_in_its_band() -> None:
    """The drive is released in the band; the spring pulls with 1.8 N m, friction holds 12 N m."""
    model = valve(0.84, 0.88, 0.92)
    load = disturbance(model)
    assert load.total < load.breakaway
    for error, motion in ends_of_steps(model).values():
        assert error <= 0.01
        assert motion == 0.0


def test_a_spring_above_the_breakaway_moves_the_released_axis() -> None:
    """8.9 N m/rad pull with 13.65 N m at 1.5 rad, above the breakaway of 12 N m, and with at most
    8.3 N m at the other targets."""
    model = valve(8.9, 8.9, 8.9)
    load = disturbance(model)
    assert load.total > load.breakaway
    ends = ends_of_steps(model)
    assert ends[0.3][1] == ends[0.9][1] == 0.0
    assert ends[1.5][1] > model.bench.encoder.resolution


def test_synth_accepts_a_load_and_tells_its_effort_and_its_margin(tmp_path: Path) -> None:
    model = loaded(
        stiffness=near(2e-4, 5e-5, unit="N m/rad"), gravity=Gravity(near(0.03), near(0.0))
    )
    text = synth(tmp_path, model)
    assert text.code == 0, text.stderr
    told = "disturbance: up to spring and offset 0.01575 + gravity 0.03102 N m"  # 63 rad of travel
    assert told in text.stdout
    assert "with the spring: stable, modulus margin at least" in text.stdout
    assert "certificate do not include the spring" in text.stdout
    found = json.loads(synth(tmp_path, model, "--json").stdout)["disturbance"]
    assert found["spring"] == pytest.approx(63.0 * 2.5e-4)
    assert found["gravity"] == pytest.approx(math.hypot(0.031, 0.001))


def test_synth_refuses_a_spring_without_a_bound_in_one_line(tmp_path: Path) -> None:
    model = loaded(stiffness=near(2e-4, 5e-5, unit="N m/rad"))
    bench = msgspec.structs.replace(
        model.bench, mechanics=msgspec.structs.replace(model.bench.mechanics, travel=None)
    )
    refused(
        synth(tmp_path, msgspec.structs.replace(model, bench=bench)),
        4,
        "laws.load.stiffness",
        "0.0002 N m/rad",
        "mechanics.travel",
    )


@pytest.mark.accept
def test_synth_tells_no_disturbance_without_a_load(tmp_path: Path) -> None:
    assert json.loads(synth(tmp_path, clutch_model(), "--json").stdout)["disturbance"] is None


def position_of(log: Log) -> np.ndarray:
    return log.main.signals["position_true"]


def test_simulate_plays_every_term() -> None:
    free = position_of(simulate_closed_loop(clutch_model(), controller(), scenario(), HERE))
    for load in (
        {"stiffness": near(0.002, unit="N m/rad")},
        {"gravity": Gravity(near(0.03), near(0.02))},
        {"ripple": RIPPLE},
    ):
        assert (
            np.max(
                np.abs(
                    position_of(
                        simulate_closed_loop(loaded(**load), controller(), scenario(), HERE)
                    )
                    - free
                )
            )
            > 0.01
        )
