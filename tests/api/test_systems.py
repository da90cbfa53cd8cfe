"""Controllers and models as systems of python-control and scipy, and theirs as controllers of
ours."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal

from frictool.documents import Spec, load, save
from frictool.documents.controller import Controller
from frictool.documents.design_blocks import PositionLawDesign
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.lti import Lti
from frictool.synth import external_controller
from frictool.systems import (
    as_lti,
    controller_system,
    loop_system,
    plant_system,
    to_control,
    to_scipy,
)
from frictool.verify import verify
from studies.rigs.clutch_model import ROOT, clutch_model

MODEL = clutch_model()
SPEC = load(ROOT / "configs/clutch/spec.yaml", Spec)
PERIOD = MODEL.bench.sample_period_s
ANGLES = np.geomspace(1e-3, np.pi * 0.999, 300)
CROSSING = 80.0
LEAD = CROSSING * 1.32e-5 / 13.4e-3 * np.polymul([1.0, CROSSING / 3], [1.0, CROSSING / 20])
PID = signal.TransferFunction(LEAD, np.polymul([1.0 / (8 * CROSSING), 1.0], [1.0, 0.0]))


@pytest.fixture(scope="module")
def controller() -> Controller:
    return external_controller(PID, MODEL, SPEC, name="pid")


def sampled(document: Any, angles: np.ndarray) -> np.ndarray:
    """Response of a stored state space on the unit circle, by the definition."""
    a, b, c, d = (
        np.array(rows, dtype=float) for rows in (document.a, document.b, document.c, document.d)
    )
    return np.array(
        [(c @ np.linalg.solve(np.exp(1j * w) * np.eye(len(a)) - a, b) + d)[0, 0] for w in angles]
    )


def test_a_controller_has_the_response_of_its_stored_coefficients(controller: Controller) -> None:
    expected = sampled(controller.linear.discrete, ANGLES)
    ours = to_control(controller)
    assert ours.dt == PERIOD
    assert (ours.input_labels, ours.output_labels, ours.name) == (["eta"], ["drive"], "pid")
    np.testing.assert_allclose(ours(np.exp(1j * ANGLES)), expected, rtol=1e-10)
    _, theirs = signal.dfreqresp(to_scipy(controller), ANGLES)
    np.testing.assert_allclose(theirs, expected, rtol=1e-6)  # scipy goes by polynomials


def test_it_is_the_continuous_one_by_tustin(controller: Controller) -> None:
    s = 2.0 / PERIOD * 1j * np.tan(0.5 * ANGLES)
    expected = np.polyval(PID.num, s) / np.polyval(PID.den, s)
    np.testing.assert_allclose(to_control(controller)(np.exp(1j * ANGLES)), expected, rtol=1e-6)


@pytest.mark.parametrize("which", [0, -1])
def test_a_vertex_has_the_stored_margin(controller: Controller, which: int) -> None:
    """The loop put together by python-control alone, from the physical parameters: zero-order hold,
    delay, controller."""
    import control  # takes a second, which the collection of the tests does not need

    vertex, lag = controller.verified.vertices[which], MODEL.bench.actuator.loop_time_constant_s
    axis = control.tf(
        [vertex.constant], np.polymul([lag, 1.0], [vertex.inertia, vertex.viscous, 0.0])
    )
    plant, angles = (
        control.sample_system(control.ss(axis), PERIOD, "zoh"),
        np.linspace(0.02, 0.6, 4000),
    )
    z = np.exp(1j * angles)
    open_loop = to_control(controller)(z) * plant(z) * z**-controller.delay_samples
    assert 1.0 / np.abs(1.0 / (1.0 + open_loop)).max() == pytest.approx(
        vertex.modulus_margin, rel=1e-6
    )
    ours = loop_system(controller, vertex.name).response(angles / PERIOD)[:, 0, 0]
    np.testing.assert_allclose(ours, open_loop, rtol=1e-7)


def test_a_model_is_its_axis() -> None:
    axis, lag = to_control(MODEL), MODEL.bench.actuator.loop_time_constant_s
    s = 1j * np.geomspace(1.0, 1e4, 50)
    p = MODEL.parameters
    expected = MODEL.bench.actuator.constant.value / (
        (lag * s + 1.0) * (p.inertia.value * s + p.viscous.value) * s
    )
    assert axis.dt == 0
    np.testing.assert_allclose(axis(s), expected, rtol=1e-9)
    held = plant_system(MODEL, sampled=True)
    assert held.period == PERIOD
    assert to_scipy(held).dt == PERIOD
    assert isinstance(to_scipy(MODEL), signal.StateSpace)
    assert to_scipy(MODEL).dt is None


@pytest.mark.parametrize(
    "given",
    [
        lambda control: control.tf(PID.num, PID.den),
        lambda control: control.ss(control.tf(PID.num, PID.den)),
        lambda control: control.sample_system(
            control.ss(control.tf(PID.num, PID.den)), PERIOD, "bilinear"
        ),
        lambda _: PID,
        lambda _: PID.to_ss(),
        lambda _: PID.to_zpk(),
        lambda _: signal.StateSpace(
            *signal.cont2discrete(
                (PID.to_ss().A, PID.to_ss().B, PID.to_ss().C, PID.to_ss().D), PERIOD, "bilinear"
            )[:4],
            dt=PERIOD,
        ),
    ],
    ids=[
        "control.tf",
        "control.ss",
        "control sampled",
        "scipy tf",
        "scipy ss",
        "scipy zpk",
        "scipy sampled",
    ],
)
def test_whoever_s_system_it_is_the_same(
    given: Callable[[Any], Any], controller: Controller
) -> None:
    import control

    found = as_lti(given(control), PERIOD)
    response = found.response(ANGLES / PERIOD)[:, 0, 0]
    np.testing.assert_allclose(
        response, controller_system(controller).response(ANGLES / PERIOD)[:, 0, 0], rtol=1e-5
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            lambda control: control.ss(
                np.eye(1) * 0.5, np.ones((1, 2)), np.ones((1, 1)), np.zeros((1, 2)), PERIOD
            ),
            "2 inputs and 1 outputs",
        ),
        (
            lambda control: control.tf([1.0], [1.0, -0.5], 2 * PERIOD),
            "is sampled at 0.002 s; allowed: continuous, or the sample period of 0.001 s",
        ),
        (lambda control: control.tf([1.0, 0.0], [1.0]), "improper"),
        (lambda control: control.ss([[0.5]], [[1.0]], [[np.inf]], [[0.0]], PERIOD), "not finite"),
        (lambda _: 3.0, "a float is not a linear system"),
    ],
)
def test_what_is_no_such_system_is_refused(given: Callable[[Any], Any], words: str) -> None:
    import control

    system = given(control)
    with pytest.raises(FrictoolError, match=words):
        as_lti(system, PERIOD)


def test_one_s_own_controller_is_verified_kept_and_read_again(
    controller: Controller, tmp_path: Path
) -> None:
    assert controller.method == "own"
    found = verify(controller)
    assert found.proved == ()  # it has no certificate
    assert found.unaltered
    save(controller, tmp_path / "pid.yaml")
    assert load(tmp_path / "pid.yaml") == controller


def test_one_s_own_speed_loop_goes_under_a_position_law() -> None:
    lead = signal.TransferFunction(LEAD[:2], [1.0 / (8 * CROSSING), 1.0])
    law = PositionLawDesign(action="cut", kind="square_root", formula="sqrt(F/J)")
    found = external_controller(lead, MODEL, SPEC, position_law=law)
    assert found.structure == "speed_cascade"
    assert found.position_law is not None
    assert verify(found).unaltered


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (signal.TransferFunction(10.0 * LEAD, PID.den), "unstable at vertex|modulus margin"),
        (signal.TransferFunction([1.0], [1.0, -1.0]), "itself unstable"),
        (signal.TransferFunction(LEAD, [1.0, 0.0, 0.0]), "2 integrators"),
    ],
)
def test_what_is_not_verified_is_refused(system: Any, words: str) -> None:
    with pytest.raises(NoSolutionError, match=words):
        external_controller(system, MODEL, SPEC)


def test_vertices_are_those_of_the_controller(controller: Controller) -> None:
    with pytest.raises(FrictoolError, match="no vertex 'v99'; allowed: v01, v02"):
        loop_system(controller, "v99")
    with pytest.raises(FrictoolError, match="a model has no vertex"):
        plant_system(MODEL, "v01")


@pytest.mark.parametrize(
    "function",
    [to_control, to_scipy, controller_system, plant_system, lambda it: loop_system(it, "v01")],
)
def test_what_is_no_model_and_no_controller_is_told(function: Any) -> None:
    with pytest.raises(FrictoolError, match=r"found int; allowed: (Model, )?Controller"):
        function(42)
    with pytest.raises(
        FrictoolError, match=r"found Mechanism; allowed: .*; reduce it to a model first"
    ):
        function(load(ROOT / "configs/clutch/mechanism.yaml"))


def test_python_control_is_asked_for_where_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ImportError, match=r"pip install .frictool\[control\]"):
        to_control(Lti(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.eye(1), PERIOD))
