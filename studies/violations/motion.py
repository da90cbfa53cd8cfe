"""Simulator of a machine that violates the model: two masses on a belt, one of them with friction.

The simulator shares no code with the engine of frictool. Between two samples it makes fixed steps
of the fourth-order Runge-Kutta method. A step in which the velocity changes its sign is shortened
to the zero of the velocity; the axis then rests until the effort exceeds the friction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

STEPS = 10  # Runge-Kutta steps per sample
HARMONICS = 3  # harmonics of the cogging torque


class Physics(NamedTuple):
    """Machine in SI units (rotary axis, rad and N m); a value of 0 switches an effect off.

    - belt_inertia, belt_stiffness, belt_damping: inertia behind the belt, and the belt
    - stribeck, stribeck_speed: additional friction at rest, and the speed of its fall
    - coulomb_direction, viscous_direction: relative difference from the mean, forward
    - position_share, position_rate, position_phase: relative amplitude, rate [rad/rad] and phase of
      the friction over position
    - transmitted: friction torque divided by the torque that accelerates the inertia
    - coulomb_warming, viscous_warming, warming_time: relative changes during the time [s]
    - offset_drift, drift_rate: amplitude [N m] and angular frequency [rad/s] of a slow offset
    - gravity, gravity_phase: amplitude [N m] and phase of the torque of a pendulum
    - spring: stiffness [N m/rad]
    - cogging_rate, cogging_*: cycles over position [rad/rad], amplitudes [N m] and phases of the
      harmonics
    - lag: time constant of the current loop [s]
    """

    inertia: float
    viscous: float
    coulomb: float
    offset: float
    belt_inertia: float = 0.0
    belt_stiffness: float = 0.0
    belt_damping: float = 0.0
    stribeck: float = 0.0
    stribeck_speed: float = 1.0
    coulomb_direction: float = 0.0
    viscous_direction: float = 0.0
    position_share: float = 0.0
    position_rate: float = 1.0
    position_phase: float = 0.0
    transmitted: float = 0.0
    coulomb_warming: float = 0.0
    viscous_warming: float = 0.0
    warming_time: float = 1.0
    offset_drift: float = 0.0
    drift_rate: float = 0.0
    gravity: float = 0.0
    gravity_phase: float = 0.0
    spring: float = 0.0
    cogging_rate: float = 0.0
    cogging_1: float = 0.0
    cogging_2: float = 0.0
    cogging_3: float = 0.0
    cogging_phase_1: float = 0.0
    cogging_phase_2: float = 0.0
    cogging_phase_3: float = 0.0
    lag: float = 0.0


class Servo(NamedTuple):
    """Test of the machine: a position servo or, with zero gains, a prescribed effort.

    - gain, damping: gains of position [N m/rad] and velocity [N m s/rad]
    - limit: largest effort [N m]
    """

    gain: float
    damping: float
    limit: float


@kernel
def warmed(p: Physics, share: float, time: float) -> float:
    """Return the factor of friction that changes by `share` over the log, with a mean near 1."""
    return 1.0 + share * (0.5 - time / p.warming_time)


@kernel
def coulomb_level(p: Physics, x: float, v: float, time: float, direction: float) -> float:
    """Return the friction without its viscous and transmitted parts [N m]."""
    level = p.coulomb * warmed(p, p.coulomb_warming, time)
    level *= 1.0 + p.coulomb_direction * direction
    level *= 1.0 + p.position_share * np.sin(p.position_rate * x + p.position_phase)
    return float(level + p.stribeck * np.exp(-((v / p.stribeck_speed) ** 2)))


@kernel
def load(p: Physics, x: float, time: float) -> float:
    """Return the load torque without friction [N m]."""
    angle = p.cogging_rate * x
    return float(
        p.offset
        + p.offset_drift * np.sin(p.drift_rate * time)
        + p.gravity * np.sin(x + p.gravity_phase)
        + p.spring * x
        + p.cogging_1 * np.sin(angle + p.cogging_phase_1)
        + p.cogging_2 * np.sin(2.0 * angle + p.cogging_phase_2)
        + p.cogging_3 * np.sin(3.0 * angle + p.cogging_phase_3)
    )


@kernel
def slopes(
    p: Physics, y: Vector, time: float, effort: float, direction: float, out: Vector
) -> None:
    """Write the time derivative of the state [x, v, belt x, belt v, effort] to `out`."""
    driven = effort if p.lag == 0.0 else y[4]
    belt = p.belt_stiffness * (y[0] - y[2]) + p.belt_damping * (y[1] - y[3])
    acceleration = 0.0
    if direction != 0.0:
        viscous = p.viscous * (1.0 + p.viscous_direction * direction)
        net = driven - belt - load(p, y[0], time)
        net -= direction * coulomb_level(p, y[0], y[1], time, direction)
        net -= viscous * warmed(p, p.viscous_warming, time) * y[1]
        # |a| adds friction: p.transmitted * inertia * |a| against the motion
        sense = direction if net > 0.0 else -direction
        acceleration = net / (p.inertia * (1.0 + sense * p.transmitted))
    out[0] = y[1] if direction != 0.0 else 0.0
    out[1] = acceleration
    out[2] = y[3]
    out[3] = belt / p.belt_inertia if p.belt_inertia > 0.0 else 0.0
    out[4] = (effort - y[4]) / p.lag if p.lag > 0.0 else 0.0


@kernel
def runge_kutta(
    p: Physics, y: Vector, time: float, effort: float, direction: float, step: float, work: Vector
) -> None:
    """Advance the state `y` by a step; `work` is (6, 5) flattened."""
    k1, k2, k3, k4, z = work[0:5], work[5:10], work[10:15], work[15:20], work[20:25]
    slopes(p, y, time, effort, direction, k1)
    for i in range(5):
        z[i] = y[i] + 0.5 * step * k1[i]
    slopes(p, z, time + 0.5 * step, effort, direction, k2)
    for i in range(5):
        z[i] = y[i] + 0.5 * step * k2[i]
    slopes(p, z, time + 0.5 * step, effort, direction, k3)
    for i in range(5):
        z[i] = y[i] + step * k3[i]
    slopes(p, z, time + step, effort, direction, k4)
    for i in range(5):
        y[i] += step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])


@kernel
def copy(source: Vector, target: Vector) -> None:
    """Copy five numbers in a loop, because `target[:] = source` compiles two seconds longer."""
    for i in range(5):
        target[i] = source[i]


@kernel
def start_direction(p: Physics, y: Vector, time: float, effort: float) -> float:
    """Return the direction in which an axis at rest starts, 0 if it stays at rest."""
    driven = effort if p.lag == 0.0 else y[4]
    belt = p.belt_stiffness * (y[0] - y[2]) - p.belt_damping * y[3]
    net = driven - belt - load(p, y[0], time)
    if net > coulomb_level(p, y[0], 0.0, time, 1.0):
        return 1.0
    if net < -coulomb_level(p, y[0], 0.0, time, -1.0):
        return -1.0
    return 0.0


@kernel
def play(
    p: Physics,
    servo: Servo,
    played: Vector,
    rate: Vector,
    period: float,
    count: float,
    motion: Vector,
    effort: Vector,
) -> None:
    """Fill position and velocity in `motion` (2, n), and the commanded `effort` (n,) [N m].

    - played: reference position [rad] (n,) or, with zero gains, prescribed effort [N m] (n,)
    - rate: reference velocity (n,) [rad/s]
    - count: encoder step of the servo [rad]
    """
    y = np.zeros(5)
    before = np.zeros(5)
    work = np.zeros(25)
    direction = 0.0
    step = period / STEPS
    for k in range(played.shape[0]):
        motion[0, k] = y[0]
        motion[1, k] = y[1]
        u = played[k]
        if servo.gain > 0.0:
            seen = np.floor(y[0] / count) * count
            u = servo.gain * (played[k] - seen) + servo.damping * (rate[k] - y[1])
        u = min(max(u, -servo.limit), servo.limit)
        effort[k] = u
        for i in range(STEPS):
            time = k * period + i * step
            if direction == 0.0:
                direction = start_direction(p, y, time, u)
            copy(y, before)
            runge_kutta(p, y, time, u, direction, step, work)
            if direction != 0.0 and y[1] * direction < 0.0:
                share = before[1] / (before[1] - y[1])
                copy(before, y)
                runge_kutta(p, y, time, u, direction, share * step, work)
                y[1] = 0.0
                time += share * step
                direction = start_direction(p, y, time, u)
                runge_kutta(p, y, time, u, direction, (1.0 - share) * step, work)
                if y[1] * direction < 0.0:
                    y[1] = 0.0
                    direction = 0.0
