"""Zero exclusion of loops that feed back a speed: what is proved is true of every plant."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.state_space import read_state_space, stored_state_space
from frictool.documents.certificate import Bound, Box, Certificate
from frictool.documents.controller import StateSpace, Velocity
from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.synth.certificate_bounds import certify
from frictool.verify import zero_exclusion
from frictool.verify.certificate_loop import (
    SENSITIVITY,
    CertificateLoop,
    SpeedFeedback,
    quantity_loops,
)
from frictool.verify.document_check import check_feedback
from frictool.verify.exponential_enclosure import hold_polynomials
from frictool.verify.feedback_loops import open_loop, speed_feedback
from frictool.verify.zero_exclusion import prove, prove_bound, prove_bounds
from frictool.verify.zero_exclusion_kernel import (
    enclose_responses,
    loop_terms,
    turn,
    workspace,
)
from tests.verify.gentle_loop import BOX, LAG, PERIOD

# PI controller K (1 + T/(T_i (z - 1))) of the speed
PI = Lti(*(np.array([[value]]) for value in (1.0, 1.0, 0.04 / 60.0, 0.04)), PERIOD)
SPEEDS = {
    "difference": Velocity(),
    "first order": Velocity(bandwidth_rad_s=600.0),
    "second order": Velocity(bandwidth_rad_s=800.0, order=2),
    "measured": Velocity(source="measured"),
}
GAIN = 12.0  # of the position law, 1/s


def _loop(
    velocity: Velocity, gain: float, lag: float = LAG, delay: int = 1, controller: Lti = PI
) -> CertificateLoop:
    return CertificateLoop(
        stored_state_space(controller),
        "position",
        delay,
        lag,
        PERIOD,
        SENSITIVITY,
        speed=SpeedFeedback(velocity, gain),
    )


def _sensitivity(loop: CertificateLoop, rates: AxisRates) -> float:
    """The largest sensitivity in floating point; inf if the loop is unstable."""
    assert loop.speed is not None
    feedback = speed_feedback(
        read_state_space(loop.controller, PERIOD), loop.speed.velocity, loop.speed.position_gain,
        PERIOD,
    )  # fmt: skip
    check = check_feedback(feedback, rates, loop.lag, loop.delay)
    return 1.0 / check.modulus_margin if check.stable else np.inf


def _kernel(
    loop: CertificateLoop, box: Box
) -> tuple[zero_exclusion.KernelLoop, zero_exclusion.KernelBox]:
    ratio = Fraction(loop.period) / Fraction(loop.lag) if loop.lag else Fraction(0)
    sigma = zero_exclusion._surroundings(box, loop.period)[1]
    return (
        zero_exclusion._kernel_loop(loop, hold_polynomials(ratio, *sigma)),
        zero_exclusion._kernel_box(box, loop.period),
    )


@pytest.mark.parametrize("velocity", SPEEDS)
@pytest.mark.parametrize("gain", [0.0, GAIN])
@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 2])
def test_the_enclosed_sensitivity_and_poles_are_those_of_the_loop(
    velocity: str, gain: float, lag: float, delay: int
) -> None:
    loop = _loop(SPEEDS[velocity], gain, lag, delay)
    j, sigma, k = 1.3e-5, 3e-4, 0.0132
    rates = AxisRates(k / j, sigma / j, 0.0)
    feedback = speed_feedback(PI, SPEEDS[velocity], gain, PERIOD)
    system = open_loop(feedback, rates, lag, delay)
    one, plants = _kernel(loop, Box((j, j), (sigma, sigma), (0.0, 0.0), (k, k)))
    kappa, rate = k * PERIOD**2 / j, sigma * PERIOD / j - one.middle
    space = workspace(one)
    for chart, t in ((0, 5e-4), (0, 0.02), (0, 0.9), (1, 0.3), (1, 0.0)):
        z = (1 + 1j * t) / (1 - 1j * t) if chart == 0 else (t + 1j) / (t - 1j)
        gain_at = system.d + system.c @ np.linalg.solve(
            z * np.eye(system.order) - system.a, system.b
        )
        terms = loop_terms(one, plants, chart, np.array([t, t, kappa, kappa, rate, rate]), space)
        remainder = enclose_responses(one, terms, space)
        assert space.parts[0, 0, 0] == pytest.approx(1.0 / (1.0 + gain_at[0, 0]), rel=1e-7)
        assert remainder < 1e-9
    # the angle of D counts the roots in the circle: those of the loop with every state
    closed = system.a - system.b @ system.c / (1.0 + system.d[0, 0])
    roots = np.linalg.eigvals(closed)
    angle, error = turn(one, plants, (kappa, rate), 100_000)
    assert error < 1e-6
    outside = int(np.sum(abs(roots) > 1.0))
    assert angle == pytest.approx(0.5 * np.pi * (len(roots) - 2 * outside), abs=1e-6)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_no_plant_exceeds_the_proved_sensitivity(seed: int) -> None:
    random = np.random.default_rng(seed)
    velocity = SPEEDS[str(random.choice(list(SPEEDS)))]
    loop = _loop(
        velocity,
        float(random.choice([0.0, random.uniform(2.0, 30.0)])),
        float(random.choice([0.0, LAG])),
        int(random.integers(0, 3)),
        Lti(PI.a, PI.b, PI.c * random.uniform(0.3, 2.0), PI.d * random.uniform(0.2, 2.0), PERIOD),
    )
    j = np.sort(random.uniform(1e-5, 2e-5, 2))
    sigma = np.sort(random.uniform(0.0, 1e-3, 2))
    k = np.sort(random.uniform(0.01, 0.015, 2))
    box = Box(*(tuple(map(float, ends)) for ends in (j, sigma, (0.0, 0.1), k)))
    try:
        certificate, (proved,) = certify(loop, box)
    except NoSolutionError:  # an unstable plant
        return
    assert [bound.of for bound in certificate.bounds] == ["sensitivity"]
    assert prove(certificate, loop) == (proved,)
    corners = np.array(np.meshgrid(j, sigma, k)).reshape(3, -1).T
    inside = random.uniform([j[0], sigma[0], k[0]], [j[1], sigma[1], k[1]], (15, 3))
    seen = max(
        _sensitivity(one, AxisRates(constant / inertia, viscous / inertia, 0.0))
        for inertia, viscous, constant in np.vstack([corners, inside])
        for one in quantity_loops(loop, "sensitivity")
    )
    assert seen < proved.below <= 1.02 * seen


@pytest.mark.parametrize("velocity", SPEEDS)
@pytest.mark.parametrize("gain", [0.0, GAIN])
def test_a_changed_loop_is_not_proved(velocity: str, gain: float) -> None:
    """Controller, filter and law take part in the proof."""
    loop = _loop(SPEEDS[velocity], gain)
    certificate, _ = certify(loop, BOX)
    stiffer = StateSpace(loop.controller.a, loop.controller.b, ((0.04 / 20.0,),), ((0.06,),))
    changed = [replace(loop, controller=stiffer), replace(loop, delay=2), replace(loop, lag=0.006)]
    if gain:
        changed.append(_loop(SPEEDS[velocity], 4.0 * gain))
    if SPEEDS[velocity].bandwidth_rad_s:
        slow = msgspec.structs.replace(SPEEDS[velocity], bandwidth_rad_s=150.0)
        changed.append(_loop(slow, gain))
    for one in changed:
        with pytest.raises(NoSolutionError, match="not proved: sensitivity"):
            prove(certificate, one)


def test_the_proof_covers_the_loop_of_the_law_and_the_speed_loop() -> None:
    loop = _loop(Velocity(), GAIN)
    inner, outer = quantity_loops(loop, "sensitivity")
    (proved,) = certify(loop, BOX)[1]
    alone = [prove_bound(one, BOX, proved.below) for one in (inner, outer)]
    assert all(isinstance(one, int) for one in alone)
    assert proved.cells == sum(alone)
    louder = replace(loop, speed=SpeedFeedback(Velocity(), 20.0 * GAIN))
    stable, _ = quantity_loops(louder, "sensitivity")
    assert prove_bound(stable, BOX, proved.below) == alone[0]
    with pytest.raises(NoSolutionError, match="unstable"):
        prove_bounds(quantity_loops(louder, "sensitivity"), BOX, 1e6)


@pytest.mark.parametrize("gain", [0.0, GAIN])
def test_an_unstable_hidden_state_is_found(gain: float) -> None:
    """The frequency responses are those of PI; the state with the pole 1.01 is hidden."""
    hidden = Lti(
        np.diag([1.0, 1.01]),
        np.vstack([PI.b, [[1.0]]]),
        np.hstack([PI.c, [[0.0]]]),
        PI.d,
        PERIOD,
    )
    with pytest.raises(NoSolutionError, match="unstable"):
        prove_bound(_loop(Velocity(), gain, controller=hidden), BOX, 1e3)


def test_a_norm_is_no_bound_of_a_speed_loop() -> None:
    loop = _loop(Velocity(), 0.0)
    certificate = Certificate(2, BOX, SENSITIVITY, (Bound("norm", 1e6),))
    with pytest.raises(NoSolutionError, match="allowed: sensitivity"):
        prove(certificate, loop)
