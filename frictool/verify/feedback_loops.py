"""Linear loops of a controller with its surrounding blocks, each opened at the drive.

The blocks determine how the drive depends on the measured signals. With references at rest,
position x and speed v:

    position, and speed_cascade with input eta     drive = C(z) eta, eta = -x
    speed_cascade with input speed_error           drive = C(z) F(z) m,
                                                   m = -(x[k] - x[k-1])/T, or -v measured
    with a proportional law, v_c = K_p (r - x)     drive = C(z) (F(z) m - K_p x) for speed_error,
                                                   C(z) (1 + K_p T z/(z - 1)) eta for eta

C is the linear controller, F the velocity block, K_p the law's gain, r the position reference, and
v_c the speed reference. If an observer estimates the speed (verify/observer_loop.py), F m is the
observer's estimate from m and from the drive. The path from the drive to the observer is then part
of the controller: the loop is opened after controller and observer.

A proportional law is linear and gives a second, outer loop; both loops are checked. If a loop feeds
back the speed only, the position is a state of the loop only if the axis has a spring. A
square-root law, a limiter and friction compensation are nonlinear and not part of any loop. The
virtual friction of a limiter is checked in a separate loop near standstill. This loop contains the
largest slope F_cv/v_r of the virtual friction (F_cv: virtual Coulomb friction, v_r: virtual speed).

    L(z) = -(transfer from the commanded to the requested drive),  sensitivity 1/(1 + L)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.adapters.state_space import read_state_space
from frictool.control.second_order_sections import chain_state_space
from frictool.control.speed_filter import first_order
from frictool.documents.controller import Controller, LinearController, PositionLaw, Row, Velocity
from frictool.documents.design import Structure
from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import INPUTS, AxisRates, linear_axis
from frictool.plant.lti import Lti, delay, gain
from frictool.verify.coefficient_rounding import CoefficientRounder
from frictool.verify.observer_loop import DRIVEN, SHOWN, ObserverSpeed, shown_speeds

ETA, DIFFERENCE, SPEED = "eta", "difference", "sampled_speed"


@dataclass(frozen=True)
class FeedbackLoop:
    """Linear feedback from measured signals to the drive.

    - sees: names of the measured signals
    - system: system with these signals as inputs and the drive as output
    - name: name of the loop in messages
    """

    name: str
    system: Lti
    sees: tuple[str, ...]


def running_form(linear: LinearController, period: float) -> Lti:
    """Return the linear controller in the form for the target hardware: matrices or sections.

    For sections, the states are s1, s2 of each section in the order of the chain.
    """
    if linear.form == "state_space":
        return read_state_space(linear.discrete, period)
    return chain(linear.sos, period)


def chain(sections: tuple[Row, ...], period: float) -> Lti:
    """Return a chain of second-order sections as a system (control/second_order_sections.py)."""
    a, b, c, d = chain_state_space(sections)
    return Lti(a, b[:, None], c[None, :], np.array([[d]]), period)


def feedbacks(
    structure: Structure,
    linear: LinearController,
    law: PositionLaw | None,
    velocity: Velocity,
    period: float,
    hold: CoefficientRounder = float,
) -> tuple[FeedbackLoop, ...]:
    """Return the loop of the linear controller and, with a proportional law, the outer loop.

    The outer loop is the last in the tuple.

    - hold: function that rounds the coefficients of velocity filter and position law to a number
      format (verify/coefficient_rounding.py)
    """
    c = running_form(linear, period)
    if structure == "position":
        return (FeedbackLoop("position loop", c, (ETA,)),)
    gain_of_law = hold(law.gain) if law is not None and law.kind == "proportional" else 0.0
    if linear.input == "eta":
        loops = [FeedbackLoop("speed loop", c, (ETA,))]
        if gain_of_law:
            loops.append(
                FeedbackLoop(
                    "position loop", _series(_one_plus_integral(gain_of_law, period), c), (ETA,)
                )
            )
        return tuple(loops)
    if velocity.observer is not None:
        return _observed(c, gain_of_law, shown_speeds(velocity.observer, hold))
    gains = (0.0, gain_of_law) if gain_of_law else (0.0,)
    return tuple(speed_feedback(c, velocity, gain, period, hold) for gain in gains)


def speed_feedback(
    c: Lti,
    velocity: Velocity,
    position_gain: float,
    period: float,
    hold: CoefficientRounder = float,
) -> FeedbackLoop:
    """Return the speed loop or, for `position_gain` > 0, the position loop around the speed loop.

    - c: linear controller
    - position_gain: gain of the proportional law [1/s]
    - period: sample period [s]
    - hold: function that rounds coefficients to a number format
    """
    sees = SPEED if velocity.source == "measured" else DIFFERENCE
    behind = low_pass(velocity, period, hold)
    if not position_gain:
        return FeedbackLoop("speed loop", _series(behind, c), (sees,))
    entering = connect(
        {"filter": DiagramBlock(behind, (sees,), ("seen",))},
        {"error": {ETA: position_gain, "seen": 1.0}},
        (ETA, sees),
        ("error",),
    )
    return FeedbackLoop("position loop", _series(entering, c), (ETA, sees))


def _observed(
    c: Lti, gain_of_law: float, speeds: tuple[ObserverSpeed, ...]
) -> tuple[FeedbackLoop, ...]:
    loops = [
        FeedbackLoop(
            f"speed loop{_of(shown)}", _around(c, shown, {SHOWN: 1.0}, (DIFFERENCE,)), (DIFFERENCE,)
        )
        for shown in speeds
    ]
    if gain_of_law:
        entering = {SHOWN: 1.0, ETA: gain_of_law}
        loops += [
            FeedbackLoop(
                f"position loop{_of(shown)}",
                _around(c, shown, entering, (ETA, DIFFERENCE)),
                (ETA, DIFFERENCE),
            )
            for shown in speeds
        ]
    return tuple(loops)


def _of(shown: ObserverSpeed) -> str:
    return f", {shown.mode}" if shown.mode else ""


def _around(c: Lti, shown: ObserverSpeed, entering: dict[str, float], sees: tuple[str, ...]) -> Lti:
    blocks = {
        "controller": DiagramBlock(c, ("entering",), (DRIVEN,)),
        "observer": DiagramBlock(shown.system, (DIFFERENCE, DRIVEN), (SHOWN,)),
    }
    return connect(blocks, {"entering": entering}, sees, (DRIVEN,))


def feedbacks_of(controller: Controller) -> tuple[FeedbackLoop, ...]:
    """Return the linear loops of a controller document."""
    return feedbacks(
        controller.structure,
        controller.linear,
        controller.position_law,
        controller.velocity,
        controller.sample_period_s,
    )


def virtual_friction(slope: float, velocity: Velocity, period: float) -> tuple[FeedbackLoop, ...]:
    """Return the loops through a limiter's virtual friction near standstill.

    If an observer estimates the speed, there is one loop for each mode of the observer; else there
    is one loop.

    - slope: drive per speed near standstill, F_cv/(v_r K) [A | V per rad/s | m/s], with the virtual
      Coulomb friction F_cv, the virtual speed v_r, and the effort K per unit of drive
    """
    if velocity.observer is not None:
        law = gain(slope, period)
        return tuple(
            FeedbackLoop(
                f"virtual friction{_of(shown)}",
                _around(law, shown, {SHOWN: 1.0}, (DIFFERENCE,)),
                (DIFFERENCE,),
            )
            for shown in shown_speeds(velocity.observer)
        )
    sees = SPEED if velocity.source == "measured" else DIFFERENCE
    return (
        FeedbackLoop(
            "virtual friction", _series(low_pass(velocity, period), gain(slope, period)), (sees,)
        ),
    )


def low_pass(velocity: Velocity, period: float, hold: CoefficientRounder = float) -> Lti:
    """Return the low-pass F(z) of the velocity block, of order 1 or 2, with rounded coefficients.

    F is 1 if the velocity block has no filter. Raises ValueError if an observer estimates the
    speed.
    """
    if velocity.source == "observer":
        raise ValueError("an observer estimates the speed; the velocity block has no low-pass")
    if velocity.source == "measured" or velocity.bandwidth_rad_s == 0.0:
        return gain(1.0, period)
    pole, through = (hold(value) for value in first_order(velocity.bandwidth_rad_s, period))
    # v[k] = pole v[k-1] + through (u[k] + u[k-1])
    direct = np.array([[through]])
    once = Lti(np.array([[pole]]), np.eye(1), (1.0 + pole) * direct, direct, period)
    return once if velocity.order == 1 else _series(once, once)


def from_position(feedback: FeedbackLoop) -> Lti:
    """Return the system from -(encoder position) to the drive, for the response to encoder counts.

    The speed of a separate sensor is 0 in this system: encoder counts do not affect that sensor.
    """
    period = feedback.system.period
    if feedback.sees == (ETA,):
        return feedback.system
    difference = Lti(
        np.zeros((1, 1)), np.eye(1), np.array([[-1.0 / period]]), np.array([[1.0 / period]]), period
    )
    blocks = {
        "controller": DiagramBlock(feedback.system, feedback.sees, ("u",)),
        "difference": DiagramBlock(difference, ("position",), ("quotient",)),
    }
    seen = {ETA: {"position": 1.0}, DIFFERENCE: {"quotient": 1.0}, SPEED: {}}
    return connect(blocks, {name: seen[name] for name in feedback.sees}, ("position",), ("u",))


def open_loop(
    feedback: FeedbackLoop,
    rates: AxisRates,
    lag: float,
    delay_samples: int,
    resonance: Lti | None = None,
) -> Lti:
    """Return the loop gain L(z) with one plant.

    - lag: time constant of the drive [s]
    - resonance: filter of a resonance (adapters/resonance_filter.py), or None
    """
    blocks, sums = _diagram(feedback, rates, lag, delay_samples, resonance)
    return connect(blocks, {**sums, "returned": {"u": -1.0}}, ("entering",), ("returned",))


def friction_to_speed(
    feedback: FeedbackLoop, rates: AxisRates, lag: float, delay_samples: int
) -> Lti:
    """Return the closed loop from the friction, divided by the Coulomb friction, to the speed.

    lag: time constant of the drive [s].
    """
    blocks, sums = _diagram(feedback, rates, lag, delay_samples)
    del sums["friction"]
    return connect(blocks, {**sums, "entering": {"u": 1.0}}, ("friction",), ("speed",))


def _diagram(
    feedback: FeedbackLoop,
    rates: AxisRates,
    lag: float,
    delay_samples: int,
    resonance: Lti | None = None,
) -> tuple[dict[str, DiagramBlock], dict[str, dict[str, float]]]:
    period = feedback.system.period
    blocks = {
        "controller": DiagramBlock(feedback.system, feedback.sees, ("u",)),
        "delay": DiagramBlock(delay(delay_samples, period), ("entering",), ("command",)),
        "axis": measured_axis(rates, lag, period, feedback.sees, resonance),
    }
    return blocks, {"speed_reference": {}, "friction": {}, "uncertain_effort": {}}


def measured_axis(
    rates: AxisRates, lag: float, period: float, sees: tuple[str, ...], resonance: Lti | None = None
) -> DiagramBlock:
    """Return the sampled axis of linear_axis.py; outputs: the speed, then the signals `sees`.

    The position is a state only if it is measured or if the axis has a spring.
    """
    axis = linear_axis(rates, lag, period, resonance).system
    n = axis.order
    m = len(INPUTS)
    a = np.zeros((n + 1, n + 1))
    b = np.zeros((n + 1, m))
    a[:n, :n], b[:n] = axis.a, axis.b
    moved, pushed = axis.a[n - 1].copy(), axis.b[n - 1].copy()
    moved[n - 1] -= 1.0
    pushed[INPUTS.index("speed_reference")] = 0.0
    a[n, :n], b[n] = moved / period, pushed / period  # the difference at the next sample
    outputs = {"speed": n - 2, ETA: n - 1, DIFFERENCE: n, SPEED: n - 2}
    rows = np.eye(n + 1)
    c = np.array(
        [
            -rows[outputs[name]] if name == SPEED else rows[outputs[name]]
            for name in ("speed", *sees)
        ]
    )
    positioned = ETA in sees or rates.spring != 0.0
    kept = [
        k for k in range(n + 1) if (k != n - 1 or positioned) and (k != n or DIFFERENCE in sees)
    ]
    whole = Lti(a[np.ix_(kept, kept)], b[kept], c[:, kept], np.zeros((len(c), m)), period)
    return DiagramBlock(whole, INPUTS, ("speed", *sees))


def _one_plus_integral(rate: float, period: float) -> Lti:
    """Return the system 1 + rate T z/(z - 1), with T the `period` [s].

    For the input eta, the output is eta plus the integral of the requested speed (rate times eta).
    The integral includes the current sample.
    """
    return Lti(
        np.eye(1), np.eye(1), np.array([[rate * period]]), np.array([[1.0 + rate * period]]), period
    )


def _series(first: Lti, second: Lti) -> Lti:
    n, m = first.order, second.order
    a = np.block([[first.a, np.zeros((n, m))], [second.b @ first.c, second.a]])
    b = np.vstack([first.b, second.b @ first.d])
    return Lti(a, b, np.hstack([second.d @ first.c, second.c]), second.d @ first.d, first.period)
