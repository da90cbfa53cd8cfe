"""The generalised plant of the speed loop (figure 5.25, annex figure 5), sampled, with the computational delay inside.

    inputs w   speed reference v_c; friction W1 F_c w'; measurement noise n
    outputs z  W2 (v_c - v); W3 i; W_u u         (u the commanded drive, i the drive after its lag)
    measured   eta + noise n,  eta = integral of v_c - position

    W2(s) = G2 (s/z2 + 1)/(s/p2 + 1)                                            (5.56)
    G2 = M_mod z2/p2,  p2 = z2 M_mod e_stat                                     (5.57), read with M_mod > G2 p2/(gamma z2)

W2 is discretised by Tustin. A weight on the commanded drive is not in the text: without one D12 = 0, the optimum is not attained, and
one encoder count asks for hundreds of times the drive's limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.plant.polytope import PlantPoint
from frictool.plant.sampled import sampled_axis

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class SpeedWeights:
    """W2 by its zero z2 and pole p2 [rad/s] and its gain G2; W1 = disturbance, W3 = drive, W_u = command, noise [rad or m]."""

    z2: float
    p2: float
    g2: float
    disturbance: float
    drive: float
    command: float
    noise: float

    @staticmethod
    def of(
        z2: float, modulus_margin: float, static_error: float, disturbance: float, drive: float, command: float, noise: float
    ) -> SpeedWeights:
        """The weights from what the specification says of them (5.57)."""
        p2 = z2 * modulus_margin * static_error
        return SpeedWeights(z2, p2, modulus_margin * z2 / p2, disturbance, drive, command, noise)


@dataclass(frozen=True)
class GeneralisedPlant:
    """x+ = a x + b1 w + b2 u;  z = c1 x + d11 w + d12 u;  y = c2 x + d21 w.

       w ──▶┌─────┐──▶ z
            │  P  │
    ┌─ u ──▶└─────┘──▶ y ─┐
    └──────[  K  ]◀───────┘
    """

    a: Matrix
    b1: Matrix
    b2: Matrix
    c1: Matrix
    c2: Matrix
    d11: Matrix
    d12: Matrix
    d21: Matrix

    def transformed(self, t: Matrix) -> GeneralisedPlant:
        """The same plant in coordinates x = t x_new."""
        inverse = np.linalg.inv(t)
        return GeneralisedPlant(
            inverse @ self.a @ t, inverse @ self.b1, inverse @ self.b2, self.c1 @ t, self.c2 @ t, self.d11, self.d12, self.d21
        )


def speed_plant(point: PlantPoint, lag: float, period: float, delay_samples: int, weights: SpeedWeights) -> GeneralisedPlant:
    """The generalised plant of one vertex. States: the delayed commands (`delay_samples`), [drive,] speed, eta, W2's state."""
    axis = sampled_axis(point, lag, period)
    n, d = axis.a.shape[0], delay_samples
    size = d + n + 1
    core = slice(d, d + n)
    a, b1, b2 = np.zeros((size, size)), np.zeros((size, 3)), np.zeros((size, 1))
    a[core, core] = axis.a
    for row in range(1, d):
        a[row, row - 1] = 1.0
    if d:
        b2[0, 0] = 1.0
        a[core, d - 1 : d] = axis.b_drive
    else:
        b2[core] = axis.b_drive
    b1[core, 0:1] = axis.b_reference
    b1[core, 1:2] = axis.b_friction * weights.disturbance * point.coulomb
    aw, bw, cw, dw = _tustin_lead(weights, period)
    a[-1, core] = -bw * axis.c_speed[0]
    a[-1, -1] = aw
    b1[-1, 0] = bw
    c1, d11, d12 = np.zeros((3, size)), np.zeros((3, 3)), np.zeros((3, 1))
    c1[0, core], c1[0, -1], d11[0, 0] = -dw * axis.c_speed[0], cw, dw
    c1[1, core] = weights.drive * axis.c_drive[0]
    if axis.drive_through and d:
        c1[1, d - 1] += weights.drive
    elif axis.drive_through:
        d12[1, 0] = weights.drive
    d12[2, 0] = weights.command
    c2 = np.zeros((1, size))
    c2[0, core] = axis.c_eta[0]
    return GeneralisedPlant(a, b1, b2, c1, c2, d11, d12, np.array([[0.0, 0.0, weights.noise]]))


def _tustin_lead(weights: SpeedWeights, period: float) -> tuple[float, float, float, float]:
    """W2 by Tustin as x+ = a x + b e, z = c x + d e."""
    p, z, g = weights.p2, weights.z2, weights.g2
    half = 0.5 * period
    denominator = 1.0 + p * half
    pole = (1.0 - p * half) / denominator
    through = g * p / z * (1.0 + z * half) / denominator
    previous = g * p / z * (z * half - 1.0) / denominator
    return pole, 1.0, previous + pole * through, through
