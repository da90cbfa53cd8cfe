"""Method pid: the difference equation is that of the printed controller, and nothing is claimed of
it that was not found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import cont2discrete, dlsim

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program as running
from frictool.control.compiled_program import control_step, start_at
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.pid_gains import Pid
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.design import (
    ProofScope,
    SynthesisResult,
    design_controller,
    synthesise_verified,
)
from frictool.synth.json_view import json_view
from frictool.synth.load_disturbance import disturbance
from frictool.synth.pid import sampled_pid
from frictool.synth.text_view import text
from frictool.verify.recheck import recheck, verify
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.synth.mass_documents import design, model, spec

HERE = Provenance("a test", "0")
PERIOD = 1e-3


@cache
def found(name: str) -> SynthesisResult:
    return synthesise_verified(model(), spec(), design(name), HERE)


def changed(name: str, **gains: Any) -> Controller:
    asked = design(name)
    assert asked.pid is not None
    return design_controller(
        model(),
        spec(),
        msgspec.structs.replace(asked, pid=msgspec.structs.replace(asked.pid, **gains)),
        HERE,
    )


@pytest.mark.parametrize("factor", [1e12, 1e17])
def test_a_gain_beyond_what_can_be_evaluated_is_refused(factor: float) -> None:
    gain = design("pi_root").pid
    assert gain is not None
    assert gain.speed_gain is not None
    too_large = msgspec.structs.replace(gain.speed_gain, value=factor * gain.speed_gain.value)
    with pytest.raises(NoSolutionError, match="cannot be evaluated"):
        changed("pi_root", speed_gain=too_large)


@settings(max_examples=30, deadline=None)
@given(
    st.floats(0.1, 10.0),
    st.floats(0.05, 5.0),
    st.floats(0.05, 5.0),
    st.floats(5.0, 400.0),
    st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=30),
)
def test_it_is_the_zero_order_hold_equivalent(
    gain: float, integral: float, derivative: float, ratio: float, errors: list[float]
) -> None:
    lag = derivative / ratio
    numerator = np.polyadd(
        np.polymul([lag, 1.0], [integral, 1.0]), [derivative * integral, 0.0, 0.0]
    )
    continuous = (gain * numerator, np.polymul([lag, 1.0], [integral, 0.0]))
    _, expected = dlsim(cont2discrete(continuous, PERIOD), np.array(errors))
    asked = Pid(
        gain=Quantity(1.0, unit="N/m"),
        integral_time_s=integral,
        derivative_time_s=derivative,
        filter_ratio=ratio,
    )
    k = sampled_pid(asked, gain, PERIOD)
    outputs = dlsim((k.a, k.b, k.c, k.d, PERIOD), np.array(errors))[1]
    np.testing.assert_allclose(outputs, expected, rtol=1e-6, atol=1e-6 * gain * ratio)


def test_gains_in_effort_become_gains_in_drive() -> None:
    base = model()
    actuator = msgspec.structs.replace(
        base.bench.actuator, constant=Quantity(value=4.0, unit="N/A")
    )
    stronger = msgspec.structs.replace(
        base, bench=msgspec.structs.replace(base.bench, actuator=actuator)
    )
    direct = [
        design_controller(one, spec(), design("pi_root"), HERE).linear.discrete.d[0][0]
        for one in (base, stronger)
    ]
    assert direct == pytest.approx([8.0, 2.0])


def test_the_printed_integral_time_is_refused() -> None:
    """Table 5.1 prints T_i = 0.1; without friction its poles are +0.055 +- 1.70j."""
    with pytest.raises(
        NoSolutionError,
        match=r"unstable at vertex v1 .* \(spectral radius 1\.000\d\); lower the gain, or raise "
        r"integral_time_s",
    ):
        changed("pid", integral_time_s=0.1)


def test_a_gain_beyond_what_the_sampling_stands_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="unstable at vertex v1"):
        changed("pid", gain=Quantity(value=2000.0, unit="N/m"))
    with pytest.raises(NoSolutionError, match="unstable at vertex v1"):
        changed("pi_root", speed_gain=Quantity(value=3000.0, unit="N s/m"))


def test_without_weights_the_norm_is_the_sensitivity() -> None:
    for name in ("pid", "pi_p", "pi_root"):
        verified = found(name).controller.verified
        assert verified.gamma_verified == pytest.approx(
            1.0 / min(vertex.modulus_margin for vertex in verified.vertices), rel=1e-5
        )
        assert verified.gamma_asked is None
    assert [one.name for one in found("pid").derived] == ["weights.error"]


def test_a_loop_is_proved_whatever_it_feeds_back() -> None:
    quantities = {
        "pid": {"norm", "sensitivity"},
        "pi_p": {"sensitivity"},
        "pi_root": {"sensitivity"},
    }
    for name, expected in quantities.items():
        result = found(name)
        certificate = result.controller.certificate
        assert certificate is not None
        assert {bound.of for bound in certificate.bounds} == expected
        assert verify(result.controller).holds
        proved = next(one for one in result.proved if one.of == "sensitivity")
        seen = result.controller.verified.modulus_margin
        assert proved.modulus_margin is not None
        assert 0.99 * seen < proved.modulus_margin < seen


def test_the_proportional_law_makes_the_whole_loop_the_worse_one() -> None:
    margins = {
        name: found(name).controller.verified.vertices[0].modulus_margin
        for name in ("pi_p", "pi_root")
    }
    assert margins["pi_p"] < 0.5 < margins["pi_root"]


def test_it_is_verified_again_from_the_document() -> None:
    for name in ("pid_limiter", "pi_p", "pi_root"):
        recheck(found(name).controller)
    controller = found("pi_p").controller
    law = msgspec.structs.replace(controller.position_law, gain=20.0)
    with pytest.raises(
        NoSolutionError, match=r"vertex v1 the stored coefficients give a modulus margin of 0\.\d+"
    ):
        recheck(msgspec.structs.replace(controller, position_law=law))


def test_the_integral_is_held_and_not_driven() -> None:
    linear = found("pid").controller.linear
    assert linear.conditional
    assert set(linear.anti_windup) == {0.0}
    assert linear.discrete.a[0] == (1.0, 0.0)


def test_in_sections_it_has_the_gains_of_an_observer() -> None:
    controller = design_controller(model(), spec(), design("pid", form="sos"), HERE)
    linear = controller.linear
    assert (linear.form, linear.conditional) == ("sos", False)
    assert len(linear.sos_anti_windup) == 2 * len(linear.sos)
    assert any(linear.sos_anti_windup)
    recheck(controller)
    assert "q15" not in {
        one.number for one in controller.verified.rounded
    }  # the integrator's section is rounded, its pole moves off 1
    runs, other = (
        running(controller_program(one)) for one in (controller, found("pid").controller)
    )
    start_at(runs, 0.0)
    start_at(other, 0.0)
    for position in np.linspace(0.0, 0.004, 50):
        drives = [control_step(one, 0.002, float(position), 0.0) for one in (runs, other)]
        assert drives[0] == pytest.approx(drives[1], rel=1e-6)
        assert abs(drives[0]) < controller.drive_limit
    spoilt = msgspec.structs.replace(
        linear, sos_anti_windup=tuple(-value for value in linear.sos_anti_windup)
    )
    with pytest.raises(
        NoSolutionError,
        match=r"with linear.sos_anti_windup the controller is unstable",
    ):
        recheck(msgspec.structs.replace(controller, linear=spoilt))


def test_a_proportional_controller_needs_no_state() -> None:
    controller = changed("pi_p", integral_time_s=None)
    assert controller.linear.discrete.a == ()
    assert controller.linear.discrete.d == ((8.0,),)
    recheck(controller)


def test_the_clutch_takes_a_pid_too() -> None:
    asked = msgspec.structs.replace(
        design("pid"),
        axis="rotary",
        pid=Pid(
            gain=Quantity(2e-3, unit="N m/rad"),
            integral_time_s=1.0,
            derivative_time_s=0.05,
            filter_ratio=20.0,
        ),
    )
    controller = design_controller(
        clutch_model(), load(ROOT / "configs/clutch/spec.yaml", Spec), asked, HERE
    )
    assert len(controller.verified.vertices) == 16
    assert all(
        vertex.stable and vertex.modulus_margin >= 0.5 for vertex in controller.verified.vertices
    )


def between(one: float, other: float) -> Spec:
    """The specification with a modulus margin half-way."""
    return msgspec.structs.replace(spec(), modulus_margin=0.5 * (one + other))


def with_gain(gain: float) -> Design:
    asked = design("pid")
    assert asked.pid is not None
    return msgspec.structs.replace(
        asked, pid=msgspec.structs.replace(asked.pid, gain=Quantity(value=gain, unit="N/m"))
    )


def test_a_format_that_breaks_the_margin_is_told_or_refused() -> None:
    """The margin is specified between what two formats leave of it: fixed point is told as missing,
    float refused."""
    margins = {
        one.number: one.modulus_margin
        for one in changed("pid", gain=Quantity(value=0.7, unit="N/m")).verified.rounded
    }
    assert set(margins) == {"double", "float", "q31", "q15"}
    assert margins["q15"] < margins["double"]
    missing = synthesise_verified(
        model(),
        between(margins["q15"], margins["double"]),
        with_gain(0.7),
        HERE,
        scope=ProofScope(vertices_only=True),
    )
    assert [one.number for one in missing.controller.verified.rounded] == ["double", "float", "q31"]
    assert "not verified with coefficients rounded to q15: export refuses them" in text(
        missing, disturbance(model())
    )
    margins = {
        one.number: one.modulus_margin
        for one in changed("pid", gain=Quantity(value=33.3, unit="N/m")).verified.rounded
    }
    assert margins["float"] < margins["double"]
    with pytest.raises(NoSolutionError, match="with float coefficients, the norm is"):
        design_controller(
            model(), between(margins["float"], margins["double"]), with_gain(33.3), HERE
        )


def test_a_drive_that_alternates_at_rest_is_named() -> None:
    """One count causes a large drive. Only the limiter switches the drive off."""
    lines = {}
    for name in ("pi_p", "pid_limiter"):
        result = found(name)
        loud = 0.2 * result.controller.drive_limit
        verified = msgspec.structs.replace(result.controller.verified, count_drive=loud)
        controller = msgspec.structs.replace(result.controller, verified=verified)
        lines[name] = text(replace(result, controller=controller), disturbance(model()))
    assert "20 % of the limit" in lines["pid_limiter"]
    assert "the drive stays on at rest" in lines["pi_p"]
    assert "the drive stays on at rest" not in lines["pid_limiter"]


@pytest.mark.parametrize(
    ("name", "lines"),
    [
        (
            "pi_p",
            [
                "position law: proportional, gain 10 1/s, action none",
                "velocity: measured",
                "proved for every constant plant of the box: sensitivity < ",
            ],
        ),
        (
            "pid_limiter",
            [
                "limiter: by energy (inertia 1 kg, F_c 1 N), band 0.02 m",
                "limiter: nonlinear",
                "proved for every constant",
            ],
        ),
    ],
)
def test_the_blocks_are_told(name: str, lines: list[str]) -> None:
    said, seen = (
        text(found(name), disturbance(model())),
        json_view(found(name), disturbance(model())),
    )
    assert [line for line in lines if line not in said] == []
    assert seen["velocity"] == {"source": "measured"}
    assert (seen["limiter"] is None) == (name == "pi_p")
