"""The axis between two samples, exactly: drive lag, inertia and viscous friction under held inputs (zero-order hold).

states   drive i (absent when the lag is zero), speed v, position x
inputs   commanded drive u, speed reference v_c (drives eta only), friction effort f (opposes)

i' = (u - i)/tau        J v' = K i - sigma v - f        x' = v        eta' = v_c - v
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from frictool.plant.polytope import PlantPoint

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class SampledAxis:
    """x[k+1] = a x[k] + b_drive u[k] + b_reference v_c[k] + b_friction f[k]; rows of c: drive, speed, eta.

    States: [drive,] speed, eta, where eta = integral of v_c - position. Shapes: a (n, n), each b (n, 1), each c (1, n), n = 2 or 3.
    With no lag the drive is the command itself: `c_drive` is zero and `drive_through` is one.
    """

    a: Matrix
    b_drive: Matrix
    b_reference: Matrix
    b_friction: Matrix
    c_drive: Matrix
    c_speed: Matrix
    c_eta: Matrix
    drive_through: float


def sampled_axis(point: PlantPoint, lag: float, period: float) -> SampledAxis:
    """The zero-order-hold equivalent at `period` [s] of one plant whose drive loop has the time constant `lag` [s]."""
    j, sigma, k = point.inertia, point.viscous, point.constant
    if lag > 0.0:
        a = np.array([[-1.0 / lag, 0.0, 0.0], [k / j, -sigma / j, 0.0], [0.0, -1.0, 0.0]])
        b = np.array([[1.0 / lag, 0.0, 0.0], [0.0, 0.0, -1.0 / j], [0.0, 1.0, 0.0]])
    else:
        a = np.array([[-sigma / j, 0.0], [-1.0, 0.0]])
        b = np.array([[k / j, 0.0, -1.0 / j], [0.0, 1.0, 0.0]])
    n = a.shape[0]
    held = expm(np.block([[a, b], [np.zeros((3, n + 3))]]) * period)
    ad, bd = held[:n, :n], held[:n, n:]
    unit = np.eye(n)
    speed, eta = unit[n - 2 : n - 1], unit[n - 1 : n]
    drive = unit[0:1] if lag > 0.0 else np.zeros((1, n))
    return SampledAxis(ad, bd[:, 0:1], bd[:, 1:2], bd[:, 2:3], drive, speed, eta, 0.0 if lag > 0.0 else 1.0)
