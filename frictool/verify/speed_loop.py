"""The sampled speed loop, rebuilt in physical units from the coefficients that run on the target. No solver takes part.

eta = s - position (s = integral of the speed reference, outside the loop);  drive u = C(z) eta, applied `delay` samples later.
Loop gain L(z) = C(z) P(z) z^-delay,  P from u to the position.  Sensitivity S = 1/(1 + L): from s to s - position.
Modulus margin = min |1 + L| over the unit circle = 1/max |S|, the distance of the Nyquist curve from -1 (5.57).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.controller import StateSpace
from frictool.plant.generalised import GeneralisedPlant
from frictool.plant.polytope import PlantPoint
from frictool.plant.sampled import sampled_axis
from frictool.verify.norms import peak_gain, spectral_radius

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class LoopCheck:
    """Spectral radius of the closed loop (stable below 1) and modulus margin (0 when unstable) at one computational delay."""

    delay_samples: int
    spectral_radius: float
    modulus_margin: float

    @property
    def stable(self) -> bool:
        """Whether every closed-loop pole is inside the unit circle."""
        return self.spectral_radius < 1.0


def matrices(system: StateSpace) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """(a, b, c, d) of a document's state space as arrays (n, n), (n, 1), (1, n), (1, 1)."""
    n = len(system.a)
    return (
        np.array(system.a, dtype=np.float64).reshape(n, n),
        np.array(system.b, dtype=np.float64).reshape(n, 1),
        np.array(system.c, dtype=np.float64).reshape(1, n),
        np.array(system.d, dtype=np.float64).reshape(1, 1),
    )


def check_loop(system: StateSpace, point: PlantPoint, lag: float, period: float, delay_samples: int) -> LoopCheck:
    """Stability and modulus margin of the loop around one plant."""
    ak, bk, ck, dk = matrices(system)
    axis = sampled_axis(point, lag, period)
    n, m, d = axis.a.shape[0], ak.shape[0], delay_samples
    size = n + d + m
    plant, line, own = slice(0, n), slice(n, n + d), slice(n + d, size)
    # input s; eta = s + c_eta x (the plant's eta state is minus the position when no reference drives it)
    a, b = np.zeros((size, size)), np.zeros((size, 1))
    a[plant, plant], a[own, own], a[own, plant], b[own] = axis.a, ak, bk @ axis.c_eta, bk
    entry = line if d else plant
    gain = np.eye(d)[:, 0:1] if d else axis.b_drive
    a[entry, own] = gain @ ck
    a[entry, plant] += gain @ dk @ axis.c_eta
    b[entry] = gain @ dk
    if d:
        a[plant, n + d - 1 : n + d] = axis.b_drive
        for row in range(1, d):
            a[n + row, n + row - 1] = 1.0
    c = np.zeros((1, size))
    c[:, plant] = axis.c_eta
    radius = spectral_radius(a)
    peak, _ = peak_gain(a, b, c, np.eye(1))
    return LoopCheck(d, radius, 1.0 / peak)


def performance(system: StateSpace, plant: GeneralisedPlant) -> float:
    """H-infinity norm from w to z of the generalised plant closed by the controller; inf where that is unstable."""
    ak, bk, ck, dk = matrices(system)
    a = np.block([[plant.a + plant.b2 @ dk @ plant.c2, plant.b2 @ ck], [bk @ plant.c2, ak]])
    b = np.vstack([plant.b1 + plant.b2 @ dk @ plant.d21, bk @ plant.d21])
    c = np.hstack([plant.c1 + plant.d12 @ dk @ plant.c2, plant.d12 @ ck])
    return peak_gain(a, b, c, plant.d11 + plant.d12 @ dk @ plant.d21)[0]
