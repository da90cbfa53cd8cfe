"""Method `pid`: difference equation of a PI or PID controller with the gains of the design.

    position         C(s) = K (1 + 1/(T_i s) + T_d s/(T_d s/a + 1)) on the position error
    speed_cascade    C(s) = K (1 + 1/(T_i s)) on the speed error

K is the gain, T_i the integral time, T_d the derivative time, and T_d/a the time constant of the
derivative's low-pass. Thesis (5.39) and section 5.2.3 give the formulas. The output of C is an
effort; the drive is the effort divided by the actuator's constant. C is sampled as a
zero-order-hold equivalent with sample period T. The integral and the low-pass (tau = T_d/a) take
the error of sample k into account after the command of sample k:

    C(z) = K (1 + (T/T_i)/(z - 1) + (T_d/tau) (z - 1)/(z - exp(-T/tau)))
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.pid_gains import Pid
from frictool.plant.lti import Lti
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def pid(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the controller candidate with the gains of the design; its norm has no bound."""
    gains = problem.design.pid
    assert gains is not None  # guaranteed by the validation of the design
    quantity = gains.gain or gains.speed_gain
    assert quantity is not None
    constant = problem.model.bench.actuator.constant.value
    k = sampled_pid(gains, quantity.value / constant, problem.period)
    actuator = problem.model.bench.actuator
    unit = "A" if actuator.drive == "current" else "V"
    note = (
        f"pid: gains of the design; K is {quantity.value:g} {quantity.unit}; with the constant "
        f"{constant:g} {actuator.constant.unit} this is "
        f"{quantity.value / constant:.4g} {unit} of the drive per unit of the error"
    )
    return ControllerCandidate(k, k, None, None, (note,))


def sampled_pid(gains: Pid, gain: float, period: float) -> Lti:
    """Return the zero-order-hold equivalent of the PI or PID controller of thesis (5.39).

    The states are the integral of the error and the low-pass.

    - gain: K in drive per unit of the error (rad | m, or rad/s | m/s)
    - period: sample period [s]
    """
    poles = []
    entering = []
    leaving = []
    direct = gain
    if gains.integral_time_s is not None:
        poles.append(1.0)
        entering.append(period)
        leaving.append(gain / gains.integral_time_s)
    if gains.derivative_time_s is not None and gains.filter_ratio is not None:
        kept = math.exp(-period * gains.filter_ratio / gains.derivative_time_s)
        poles.append(kept)
        entering.append(1.0 - kept)
        leaving.append(-gain * gains.filter_ratio)
        direct += gain * gains.filter_ratio
    n = len(poles)
    b = np.array(entering).reshape(n, 1)
    c = np.array(leaving).reshape(1, n)
    return Lti(np.diag(poles) if n else np.zeros((0, 0)), b, c, np.array([[direct]]), period)
