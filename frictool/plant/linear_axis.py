"""Axis (thesis 5.48) as a linear system of drive lag, inertia and viscous friction.

    tau i' = u - i          v' = k i - s v - c x - f w + p w_D    x' = v          eta' = v_c - v

    inputs   u commanded drive [A or V], v_c speed reference, w friction in [-1, 1], w_D effort of
             the uncertainty channel
    outputs  i drive, v speed, eta = integral of v_c - position

Coulomb friction enters as the input w. The rates are k = K/J, s = sigma_v/J, c = k_s/J, f = F_c/J
and p = d/J: J is the inertia, K the actuator's constant, sigma_v the viscous friction, k_s the
stiffness of a spring on the axis, F_c the Coulomb friction, and d the unit of the uncertainty
channel. With a spring, the system is valid for v_c = 0 only, because x is then -eta. tau is the
drive's lag; without a lag the drive equals the command. The linearised plant (5.49) is the same
system with other values of k, s, f and p. A sampled axis has exact zero-order holds at its inputs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.plant.block_diagram import DiagramBlock
from frictool.plant.lti import Lti, zero_order_hold

INPUTS = ("command", "speed_reference", "friction", "uncertain_effort")
OUTPUTS = ("drive", "speed", "eta")


@dataclass(frozen=True)
class AxisRates:
    """Parameters of an axis, each divided by the inertia.

    - drive: actuator's constant [rad/s^2 or m/s^2 per A or V]
    - viscous: viscous friction [1/s]
    - friction: Coulomb friction [rad/s^2 or m/s^2]
    - push: effort d of a unit signal in the uncertainty channel [rad/s^2 or m/s^2]
    - spring: stiffness of a spring on the axis [1/s^2]
    """

    drive: float
    viscous: float
    friction: float
    push: float = 0.0
    spring: float = 0.0


def linear_axis(
    rates: AxisRates, lag: float, period: float, resonance: Lti | None = None
) -> DiagramBlock:
    """Return the axis with the drive's time constant `lag` [s], continuous or sampled.

    - period: sample period [s], 0 for continuous time
    - resonance: continuous filter with static gain 1 between the drive's effort and the axis
      (adapters/resonance_filter.py)

    The states are the drive (only if it has a lag), the filter's states, the speed, and eta, which
    is (integral of the speed reference) - position. INPUTS and OUTPUTS contain the names of the
    ports.
    """
    k = rates.drive
    s = rates.viscous
    f = rates.friction
    p = rates.push
    spring = rates.spring
    if lag > 0.0:
        a = np.array([[-1.0 / lag, 0.0, 0.0], [k, -s, spring], [0.0, -1.0, 0.0]])
        b = np.array([[1.0 / lag, 0.0, 0.0, 0.0], [0.0, 0.0, -f, p], [0.0, 1.0, 0.0, 0.0]])
        c = np.eye(3)
        d = np.zeros((3, 4))
    else:
        a = np.array([[-s, spring], [-1.0, 0.0]])
        b = np.array([[k, 0.0, -f, p], [0.0, 1.0, 0.0, 0.0]])
        c = np.vstack([np.zeros((1, 2)), np.eye(2)])
        d = np.zeros((3, 4))
        d[0, 0] = 1.0
    system = Lti(a, b, c, d, 0.0)
    if resonance is not None:
        system = _resonant(system, rates, resonance)
    return DiagramBlock(zero_order_hold(system, period) if period else system, INPUTS, OUTPUTS)


def _resonant(axis: Lti, rates: AxisRates, resonance: Lti) -> Lti:
    # head: number of states before the filter's states: 1 with a lag, else 0
    head = axis.order - 2
    m = resonance.order
    a = np.zeros((head + m + 2, head + m + 2))
    b = np.zeros((head + m + 2, len(INPUTS)))
    old = [*range(head), head + m, head + m + 1]
    a[np.ix_(old, old)], b[old] = axis.a, axis.b
    a[head : head + m, head : head + m] = resonance.a
    speed = head + m
    a[speed, head : head + m] = rates.drive * resonance.c[0]
    into = resonance.b[:, 0]
    through = rates.drive * float(resonance.d[0, 0])
    if head:
        a[head : head + m, 0], a[speed, 0] = into, through
    else:
        b[head : head + m, 0], b[speed, 0] = into, through
    c = np.zeros((len(OUTPUTS), len(a)))
    c[:, old] = axis.c
    return Lti(a, b, c, axis.d, 0.0)
