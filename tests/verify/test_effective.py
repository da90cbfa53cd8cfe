"""The loops that are verified are those that run: against the program of the target sample by
sample, and against products of responses."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.model_polytope import polytope
from frictool.control.compiled_program import control_step
from frictool.documents.controller import Controller, LinearController, PositionLaw, Velocity
from frictool.documents.pid_gains import Pid
from frictool.documents.quantity import Quantity
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, gain, tustin
from frictool.synth.pid import sampled_pid
from frictool.synth.realisation import running_in_sections, stored_forms
from frictool.verify.document_check import check_feedback
from frictool.verify.encoder_count_drive import drive_after_count
from frictool.verify.feedback_loops import (
    DIFFERENCE,
    ETA,
    SPEED,
    FeedbackLoop,
    chain,
    feedbacks_of,
    from_position,
    low_pass,
    open_loop,
)
from frictool.verify.margins import loop_margins
from studies.rigs.clutch_model import clutch_model
from studies.rigs.example_controllers import clutch_controller, started

PERIOD, LAG = 1e-3, 3e-3
CLUTCH = AxisRates(1015.0, 29.0, 7500.0)
PROPORTIONAL = PositionLaw(gain=12.0, kind="proportional", action="none")
ROOT = PositionLaw(gain=81.1, formula="sqrt(F/J)", band=2.0, action="none")
VELOCITIES = {
    "difference": Velocity(),
    "first order": Velocity(order=1, bandwidth_rad_s=150.0),
    "second order": Velocity(order=2, bandwidth_rad_s=300.0),
    "measured": Velocity(source="measured"),
}
POINTS = np.geomspace(0.5, 3000.0, 60)


def pi(proportional: float = 0.05, integral_time: float = 0.1) -> LinearController:
    """K (1 + 1/(T_i s)), held."""
    k = Lti(
        np.eye(1),
        np.array([[PERIOD]]),
        np.array([[proportional / integral_time]]),
        np.array([[proportional]]),
        PERIOD,
    )
    return stored_forms(k)


def composed(
    law: PositionLaw | None,
    entering: str,
    velocity: Velocity,
    form: str = "state_space",
    **changes: Any,
) -> Controller:
    """A controller of the clutch's bench around a PI that no limit touches; without a law a
    position loop."""
    linear = pi() if form == "state_space" else running_in_sections(pi(), PERIOD)
    linear = msgspec.structs.replace(linear, input=entering)
    made = clutch_controller(law or ROOT, prefilter=False, speed=linear, limit=1e9)
    free = msgspec.structs.replace(
        made.bench, mechanics=msgspec.structs.replace(made.bench.mechanics, travel=None)
    )
    structure = "position" if law is None else "speed_cascade"
    return msgspec.structs.replace(
        made, bench=free, structure=structure, position_law=law, velocity=velocity, **changes
    )


CASES = {
    "position": (None, "eta", "difference", "state_space"),
    "position in sections": (None, "eta", "difference", "sos"),
    "eta under a proportional law": (PROPORTIONAL, "eta", "difference", "state_space"),
    "speed, difference": (PROPORTIONAL, "speed_error", "difference", "state_space"),
    "speed, first order": (PROPORTIONAL, "speed_error", "first order", "state_space"),
    "speed, second order": (PROPORTIONAL, "speed_error", "second order", "sos"),
    "speed, measured": (PROPORTIONAL, "speed_error", "measured", "state_space"),
}


@pytest.mark.parametrize("name", CASES)
@given(st.integers(0, 2**16))
@settings(max_examples=5, deadline=None)
def test_the_outermost_loop_is_what_the_target_does(name: str, seed: int) -> None:
    """The drive that the program gives for any motion is that of the system that is verified."""
    law, entering, velocity, form = CASES[name]
    controller = composed(law, entering, VELOCITIES[velocity], form)
    loop, running = feedbacks_of(controller)[-1], started(controller, 0.0)
    random = np.random.default_rng(seed)
    positions, speeds = np.cumsum(random.standard_normal(80)) * 1e-3, random.standard_normal(80)
    x, before = np.zeros(loop.system.order), 0.0
    for position, speed in zip(positions, speeds, strict=True):
        seen = {ETA: -position, DIFFERENCE: -(position - before) / PERIOD, SPEED: -speed}
        entered = np.array([seen[signal] for signal in loop.sees])
        expected = loop.system.c[0] @ x + loop.system.d[0] @ entered
        x, before = loop.system.a @ x + loop.system.b @ entered, position
        assert control_step(running, 0.0, float(position), float(speed)) == pytest.approx(
            expected, rel=1e-9, abs=1e-9
        )


def _plant(delay: int) -> Any:
    """(to the position, to the sampled speed), with the delay, at POINTS."""
    axis = linear_axis(CLUTCH, LAG, PERIOD).system.response(POINTS)
    late = np.exp(-1j * POINTS * PERIOD * delay)
    return -axis[:, 2, 0] * late, axis[:, 1, 0] * late


@pytest.mark.parametrize("velocity", VELOCITIES)
@pytest.mark.parametrize("delay", [0, 1, 2])
def test_the_open_loops_are_products_of_responses(velocity: str, delay: int) -> None:
    controller = composed(PROPORTIONAL, "speed_error", VELOCITIES[velocity])
    inner, whole = feedbacks_of(controller)
    z = np.exp(1j * POINTS * PERIOD)
    c = 0.05 * (1.0 + (PERIOD / 0.1) / (z - 1.0))
    position, speed = _plant(delay)
    w = VELOCITIES[velocity].bandwidth_rad_s
    s = 2.0 / PERIOD * (z - 1.0) / (z + 1.0)
    f = (w / (s + w)) ** VELOCITIES[velocity].order if w else 1.0
    seen = speed if velocity == "measured" else f * (1.0 - 1.0 / z) / PERIOD * position
    assert open_loop(inner, CLUTCH, LAG, delay).response(POINTS)[:, 0, 0] == pytest.approx(
        c * seen, rel=1e-8
    )
    expected = c * (seen + PROPORTIONAL.gain * position)
    assert open_loop(whole, CLUTCH, LAG, delay).response(POINTS)[:, 0, 0] == pytest.approx(
        expected, rel=1e-8
    )


def test_the_law_around_eta_adds_its_integral() -> None:
    inner, whole = feedbacks_of(composed(PROPORTIONAL, "eta", Velocity()))
    z = np.exp(1j * POINTS * PERIOD)
    around = 1.0 + PROPORTIONAL.gain * PERIOD * z / (z - 1.0)
    assert whole.system.response(POINTS)[:, 0, 0] == pytest.approx(
        inner.system.response(POINTS)[:, 0, 0] * around, rel=1e-9
    )
    assert (inner.sees, whole.sees) == ((ETA,), (ETA,))


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_a_speed_loop_leaves_the_position_free(velocity: str) -> None:
    """No pole at 1 is left of a position that nobody sees: the loop is stable, and its margins are
    those of its own sensitivity."""
    inner, *_ = feedbacks_of(composed(ROOT, "speed_error", VELOCITIES[velocity]))
    check = check_feedback(inner, CLUTCH, LAG, 1)
    assert check.spectral_radius < 1.0 - 1e-4
    assert loop_margins(open_loop(inner, CLUTCH, LAG, 1)).modulus == pytest.approx(
        check.modulus_margin, rel=1e-6
    )
    scanned = np.min(
        np.abs(
            1.0
            + open_loop(inner, CLUTCH, LAG, 1).response(np.geomspace(0.1, np.pi / PERIOD, 20000))[
                :, 0, 0
            ]
        )
    )
    assert check.modulus_margin == pytest.approx(scanned, rel=1e-4)


def test_a_square_root_law_closes_no_linear_loop() -> None:
    assert len(feedbacks_of(composed(ROOT, "speed_error", Velocity()))) == 1
    assert len(feedbacks_of(composed(ROOT, "eta", Velocity()))) == 1


def test_a_slow_filter_is_part_of_the_loop() -> None:
    margins = []
    for bandwidth in (2000.0, 300.0, 60.0):
        inner, *_ = feedbacks_of(
            composed(ROOT, "speed_error", Velocity(order=2, bandwidth_rad_s=bandwidth))
        )
        margins.append(check_feedback(inner, CLUTCH, LAG, 1).modulus_margin)
    assert margins[0] > margins[1] > margins[2]


def test_what_a_count_asks_for_through_a_difference() -> None:
    step, velocity = 0.1122, VELOCITIES["first order"]
    loop = FeedbackLoop("a", low_pass(velocity, PERIOD), (DIFFERENCE,))
    x = velocity.bandwidth_rad_s * PERIOD
    assert drive_after_count(from_position(loop), step) == pytest.approx(
        max(step / PERIOD * x / (2.0 + x) * v for v in (1.0, 1.0 + (2.0 - x) / (2.0 + x)))
    )
    assert (
        drive_after_count(from_position(FeedbackLoop("a", gain(3.0, PERIOD), (SPEED,))), step)
        == 0.0
    )
    assert drive_after_count(
        from_position(FeedbackLoop("a", gain(3.0, PERIOD), (ETA,))), step
    ) == pytest.approx(3.0 * step)


def test_a_chain_is_the_product_of_its_sections() -> None:
    sections = ((2.0, 3.0, 0.5, 1.0, -0.5, 0.06), (0.0, 1.0, 0.0, 1.0, -1.0, 0.0))
    z = np.exp(1j * POINTS * PERIOD)
    first = (2.0 + 3.0 / z + 0.5 / z**2) / (1.0 - 0.5 / z + 0.06 / z**2)
    assert chain(sections, PERIOD).response(POINTS)[:, 0, 0] == pytest.approx(
        first / z / (1.0 - 1.0 / z), rel=1e-9
    )


# the PI of the trial, its speed from (5.70) sampled whole by Tustin: worst modulus margin over
# table 5.2's vertices with delay 0 and 1
TRIAL = {(7.6e-4, 0.014, 300.0): (0.03, 0.0), (1e-3, 0.030, 1000.0): (0.59, 0.51)}


@pytest.mark.parametrize("gains", TRIAL)
def test_the_trials_pi_and_half_a_sample(gains: tuple[float, float, float]) -> None:
    """Margins that are known of C(s) s/(s/w + 1)^2; the block's difference lags by half a sample
    more than Tustin's derivative."""
    gain_, integral_time, w = gains
    constant, points = 13.4e-3, polytope(clutch_model()).vertices
    c = gain_ / constant * np.array([[w**2 * (1.0 / integral_time - w), w**2]])
    whole = tustin(
        Lti(np.array([[-w, 1.0], [0.0, -w]]), np.array([[0.0], [1.0]]), c, np.zeros((1, 1)), 0.0),
        PERIOD,
    )
    for delay, known in enumerate(TRIAL[gains]):
        found = min(
            check_feedback(
                FeedbackLoop("trial", whole, (ETA,)), point.rates, LAG, delay
            ).modulus_margin
            for point in points
        )
        assert found == pytest.approx(known, abs=0.005)
    linear = stored_forms(
        sampled_pid(
            Pid(speed_gain=Quantity(gain_), integral_time_s=integral_time), gain_ / constant, PERIOD
        )
    )
    made = composed(ROOT, "speed_error", Velocity(order=2, bandwidth_rad_s=w))
    (loop,) = feedbacks_of(
        msgspec.structs.replace(made, linear=msgspec.structs.replace(linear, input="speed_error"))
    )
    z = np.exp(1j * POINTS * PERIOD)
    s = 2.0 / PERIOD * (z - 1.0) / (z + 1.0)
    held = (1.0 + PERIOD / integral_time / (z - 1.0)) / (
        1.0 + 1.0 / (integral_time * s)
    )  # the integral held, against Tustin's
    block = from_position(loop).response(POINTS)[:, 0, 0]
    assert block == pytest.approx(
        whole.response(POINTS)[:, 0, 0] * held * (z + 1.0) / (2.0 * z), rel=1e-6
    )
