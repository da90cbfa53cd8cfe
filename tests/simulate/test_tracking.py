"""Profile and feedforward in the engine: no error on the exact plant, half of the published one on
EMPS's own reference."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.design_blocks import FeedforwardDesign, ProfileDesign
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.report.verdict import judge
from frictool.simulate.axis_plant import AxisPlant
from frictool.simulate.closed_loop import SimulationRequest, StepTest, simulate_closed_loop
from frictool.synth.design import design_controller
from frictool.typing import Vector
from studies.rigs.clutch_model import ROOT
from tests.support.measured_data import data

RIG = ROOT / "configs/emps"
ORIGIN = Provenance("a test", "0")
COUNT = 5e-8  # m, encoder step
replace = msgspec.structs.replace


def rig_model(**parameters: float) -> Model:
    """EMPS with the published values, on the bench of the rig; some parameters replaced."""
    model = load(RIG / "published.yaml", Model)
    changed = {
        name: replace(getattr(model.parameters, name), value=value)
        for name, value in parameters.items()
    }
    bench = load(RIG / "bench.yaml", Bench)
    return replace(model, bench=bench, parameters=replace(model.parameters, **changed))


def controller_of(model: Model, **blocks: Any) -> Controller:
    """The loop of tracking/ with other blocks around it."""
    design = replace(load(RIG / "tracking/design.yaml", Design), **blocks)
    spec = replace(load(RIG / "tracking/spec.yaml", Spec), drive_peak=None)
    return design_controller(model, spec, design, ORIGIN)


def steps() -> Scenario:
    """Two moves, each with a rest behind it."""
    parts = [
        Step(reference=Quantity(value=target, unit="m"), duration_s=1.2) for target in (0.15, 0.05)
    ]
    start = Quantity(value=0.05, unit="m")
    return Scenario(
        "scenario/1", "two moves", "linear", start=start, steps=tuple(parts), drive="voltage"
    )


def moved(controller: Controller, model: Model, number: Any = "double") -> dict[str, Vector]:
    log = simulate_closed_loop(
        model, controller, steps(), ORIGIN, request=SimulationRequest(number=number)
    )
    return log.main.signals


def test_without_a_mismatch_the_loop_sees_encoder_counts_only() -> None:
    """No breakaway above the Coulomb friction, no offset: what is left is the axis that starts to
    slip within a sample, and the viscous friction over a sample."""
    model = rig_model(offset=0.0, breakaway=20.3935)
    blocks = {"profile": ProfileDesign(), "feedforward": FeedforwardDesign()}
    signals = moved(controller_of(model, **blocks), model)
    error = signals["profile"] - signals["position_true"]
    assert np.max(np.abs(error)) < 20.0 * COUNT
    assert np.sqrt(np.mean(error**2)) < 3.0 * COUNT
    late = replace(blocks["feedforward"], inertia=Quantity(value=70.0, unit="kg"))
    blocks["feedforward"] = late
    wrong = moved(controller_of(model, **blocks), model)
    assert np.max(np.abs(wrong["profile"] - wrong["position_true"])) > 200.0 * COUNT


@pytest.mark.parametrize("number", ["float", "q31"])
def test_the_profile_of_each_format_ends_at_the_target(number: str) -> None:
    model = rig_model()
    controller = controller_of(model, profile=ProfileDesign(), feedforward=FeedforwardDesign())
    signals = moved(controller, model, number)
    exact = moved(controller, model)["profile"]
    assert np.max(np.abs(signals["profile"] - exact)) < {"float": 5e-6, "q31": 1e-6}.get(
        number, 2e-5
    )
    assert signals["profile"][-1] == pytest.approx(0.05, abs=COUNT)
    assert np.ptp(signals["profile"][-200:]) == 0.0


def test_a_trial_has_the_profile_of_the_log() -> None:
    """The runs of a campaign are judged without a log."""
    model = rig_model()
    controller = controller_of(model, profile=ProfileDesign(), feedforward=FeedforwardDesign())
    test = StepTest(AxisPlant(model), controller)
    (trial,) = test.runs(steps())
    logged = test.log(steps()).main.signals
    for name in ("profile", "position"):
        np.testing.assert_array_equal(test.stream(trial).signals[name], logged[name])


def test_emps_is_tracked_at_half_of_the_published_error_on_every_vertex() -> None:
    """Equal drive peak: that of the record is the limit of the drive, on every plant."""
    bench = load(RIG / "bench.yaml", Bench)
    record = read_log(data("emps", "DATA_EMPS.mat"), bench)
    spec = load(RIG / "tracking/spec.yaml", Spec)
    scenario = load(RIG / "tracking/scenario.yaml", Scenario)
    assert scenario.reference is not None
    signals = record.main.signals
    kept = record.main.time - record.main.time[0] >= scenario.reference.from_s
    published = (signals["reference"] - signals["position"])[kept]
    peak = float(np.max(np.abs(signals["voltage"])))
    assert spec.drive_peak.value <= peak
    assert spec.tracking_error_peak.value <= 0.5 * np.max(np.abs(published))
    assert spec.tracking_error_rms.value <= 0.5 * np.sqrt(np.mean(published**2))
    limited = replace(bench.actuator, limit=Quantity(value=spec.drive_peak.value, unit="V"))
    model = replace(rig_model(), bench=replace(bench, actuator=limited))
    controller = design_controller(model, spec, load(RIG / "tracking/design.yaml", Design), ORIGIN)
    log: Log = simulate_closed_loop(
        model, controller, scenario, ORIGIN, request=SimulationRequest(recorded=record)
    )
    assert len(log.streams) == 9
    verdict = judge(spec, [log], controller)
    assert verdict.passed, verdict.headline
    assert all(verdict.meets)
