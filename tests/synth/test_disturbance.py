"""A model's load at synthesis and in simulation: bounded disturbances are told, a spring is
refused, nothing is passed over in silence."""

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
from frictool.documents.laws import Gravity, Laws, Load, Ripple
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.logs.log import Log
from frictool.plant.position_load import load_effort
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.synth.load_disturbance import amplitude, disturbance
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.rigs.step_scenario import controller, scenario
from tests.support.command_line import refused
from tests.support.provenance import HERE

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


def test_synth_refuses_a_spring_in_one_line(tmp_path: Path) -> None:
    refused(
        synth(tmp_path, loaded(stiffness=near(0.02, unit="N m/rad"))),
        4,
        "laws.load.stiffness",
        "0.02 N m/rad",
        "without a spring",
    )


def test_synth_tells_the_disturbance(tmp_path: Path) -> None:
    model = loaded(gravity=Gravity(near(0.03), near(0.0)))
    text = synth(tmp_path, model)
    assert text.code == 0, text.stderr
    assert "disturbance: up to gravity 0.03102 N m" in text.stdout
    found = json.loads(synth(tmp_path, model, "--json").stdout)["disturbance"]
    assert found["gravity"] == pytest.approx(math.hypot(0.031, 0.001))


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
