"""How far an estimated velocity may be off, sample by sample.

    half^2 = (CELL_PART step w)^2 + (MODEL_PART h)^2        at most PASSED step/(time since the last count) around rest
    h      = what is left of |delta_a - its low-pass|/w     delta_a = unsure a + friction sign(v)/J, what the model may miss

The first is what an innovation within the encoder's step moves the velocity by; the second what the model may be wrong by until the
disturbance has taken it up, so that only changes of it count, and each one for about 1/w. Both are for 95 %; the parts are such that the
intervals cover on clutches that are spread as the bench says (docs/theory/velocity.md).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import kernel

Vector = NDArray[np.float64]

CELL_PART = 0.3
MODEL_PART = 1.2
PASSED = 2.0
LOW_PASS, LEFT, SINCE, SHOWN, STATE_SIZE = 0, 1, 2, 3, 4


@kernel
def velocity_interval(
    velocity: Vector,
    acceleration: Vector,
    position: Vector,
    unsure: float,
    friction: float,
    step: float,
    bandwidth: float,
    period: float,
    state: Vector,
    half: Vector,
) -> None:
    """Fills half (n,) [rad/s | m/s] for 95 %, from velocity, the model's acceleration and the measured position (n,).

    unsure: part of the inertia; friction [rad/s2 | m/s2]: of the dry friction, over the inertia. state (4,): kept from piece to piece.
    """
    pole = math.exp(-bandwidth * period)
    cell = CELL_PART * step * bandwidth
    for k in range(velocity.shape[0]):
        v = velocity[k]
        missed = unsure * acceleration[k]
        if v > 0.0:
            missed += friction
        elif v < 0.0:
            missed -= friction
        state[LOW_PASS] += (1.0 - pole) * (missed - state[LOW_PASS])
        state[LEFT] = max(pole * state[LEFT], abs(missed - state[LOW_PASS]) / bandwidth)
        state[SINCE] = period if position[k] != state[SHOWN] else state[SINCE] + period
        state[SHOWN] = position[k]
        found = math.sqrt(cell * cell + (MODEL_PART * state[LEFT]) ** 2)
        half[k] = min(found, PASSED * step / state[SINCE] + abs(v))
