"""Servo on a pendulum with BAM's friction model M6 and its published parameters.

M6 (Rhoban/bam, model.py; Duclusaud and Passault) adds three frictions to Coulomb and viscous
friction. The first grows with the motor's torque, the second with the external torque; each has a
Stribeck part. The third is quadratic, and acts while the two torques oppose each other.

The simulation does not use BAM's code. It takes short steps, in which friction stops the axis if it
can.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

FIRMWARE = (0.166, 0.97)  # duty cycle per rad and unit of the gain, and largest duty cycle
SUBSTEPS = 5  # time steps per sample
WEIGHT = 9.80665  # m/s^2
NAMES = (
    "kt",
    "R",
    "armature",
    "q_offset",
    "friction_base",
    "friction_stribeck",
    "load_friction_motor",
    "load_friction_external",
    "load_friction_motor_stribeck",
    "load_friction_external_stribeck",
    "load_friction_motor_quad",
    "load_friction_external_quad",
    "dtheta_stribeck",
    "alpha",
    "friction_viscous",
)


def parameters(path: Path) -> Vector:
    """Return the parameters of a file of BAM, in the order of NAMES."""
    published = json.loads(path.read_text(encoding="utf-8"))
    return np.array([published[name] for name in NAMES])


@kernel
def _friction(p: Vector, motor: float, external: float, speed: float) -> float:
    """Return the largest friction torque without its viscous part, N m."""
    fall = np.exp(-(abs(speed / p[12]) ** p[13]))
    gear = abs(external * p[7] - motor * p[6]) + p[4]
    gear += fall * (p[5] + abs(external * p[9] - motor * p[8]))
    if external * motor < 0.0:
        if abs(external) < abs(motor):
            gear += fall * p[11] * external**2
        else:
            gear += fall * p[10] * motor**2
    return float(gear)


@kernel
def simulated(
    p: Vector,
    pendulum: tuple[float, float],
    goal: Vector,
    volts: Vector,
    start: float,
    period: float,
) -> Vector:
    """Return the position (n,) [rad] along a goal (n,), from `start` at rest.

    pendulum: inertia [kg m^2] and torque [N m] of a horizontal arm. volts (2, n): supply times the
    torque switch, and gain times the duty cycle per rad.
    """
    inertia = pendulum[0] + p[2]
    h = period / SUBSTEPS
    x, v = start, 0.0
    out = np.empty(goal.size)
    for k in range(goal.size):
        out[k] = x
        for _ in range(SUBSTEPS):
            duty = min(max((goal[k] - x) * volts[1, k], -FIRMWARE[1]), FIRMWARE[1])
            driven = duty * volts[0, k] - (p[0] * v if volts[0, k] > 0.0 else 0.0)
            motor = p[0] / p[1] * driven
            external = -pendulum[1] * np.sin(x + p[3])
            stop = inertia / h * v + motor + external
            held = _friction(p, motor, external, v) + p[14] * abs(v)
            v += h / inertia * (motor + external - np.sign(stop) * min(abs(stop), held))
            x += h * v
    return out
