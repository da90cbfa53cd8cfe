"""Half-width of the interval of an estimated velocity, sample by sample, for 95 %.

    half^2 = (1.96 ROUNDED G_n step/sqrt(12))^2 + max(1.2 h, 1.96 G_a s, G_a r)^2       at most 2
                                                                                        step/(time
                                                                                        since the
                                                                                        last count)
                                                                                        + |v|

    rounding   a count's rounding, white, through the observer's gains: G_n. ROUNDED: the part of it
               that passes the observer's dead zone
    h          what is left of |delta_a - its low-pass|/w, delta_a = unsure a + friction sign(v)/J:
               what the model may be wrong by, until
               the disturbance has taken it up, so that only changes of it count, and each one for
               about 1/w
    s, r       what the log itself shows: by how much the measured position misses the predicted one
               beyond what rounding explains.
               s: its root mean square over some MEMORY samples in motion; noise of the drive, and
               every other steady misfit, shows there. r: its peak, which decays with the observer's
               error; impacts, and friction that begins late, show there
    G_n, G_a   of the observer's linear error (observe/design/error_gains.py)

Predicted and observed misfit are one, seen twice, hence the larger of them. ROUNDED and MODEL_PART
are such that the intervals cover on clutches that are spread as the bench says, with encoders of 56
to 1e5 counts (docs/theory/velocity.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]

QUANTILE = 1.959964  # of the normal distribution, for 95 %
ROUNDED = 0.75
MODEL_PART = 1.2
PASSED = 2.0
MEMORY = 100.0  # samples
LOW_PASS, LEFT, SINCE, SHOWN, MEAN_SQUARE, PEAK, STATE_SIZE = 0, 1, 2, 3, 4, 5, 6


class VelocityIntervalConstants(NamedTuple):
    """Settings that the interval depends on, apart from the samples.

    unsure: part of the inertia that may be wrong. friction [rad/s2 | m/s2]: dry friction that may
    be wrong, over the inertia. step, cell: of the encoder, and the observer's dead zone [rad | m].
    bandwidth [rad/s], period [s]. rounding, misfit [1/s]: `ErrorGains`.
    """

    unsure: float
    friction: float
    step: float
    cell: float
    bandwidth: float
    period: float
    rounding: float
    misfit: float


@kernel
def velocity_interval(
    velocity: Vector,
    acceleration: Vector,
    position: Vector,
    miss: Vector,
    sizes: VelocityIntervalConstants,
    state: Vector,
    half: Vector,
) -> None:
    """Fills half (n,) [rad/s | m/s] from velocity, the model's acceleration, the measured position
    and the observer's miss (n,).

    miss: measured less predicted position, beyond the dead zone. state (6,): kept from piece to
    piece.
    """
    step, period = sizes.step, sizes.period
    pole = math.exp(-sizes.bandwidth * period)
    rounding = QUANTILE * ROUNDED * sizes.rounding * step / math.sqrt(12.0)
    explained = max(0.5 * (step - sizes.cell), 0.0)  # of a miss, by rounding
    for k in range(velocity.shape[0]):
        v = velocity[k]
        missed = sizes.unsure * acceleration[k]
        if v > 0.0:
            missed += sizes.friction
        elif v < 0.0:
            missed -= sizes.friction
        state[LOW_PASS] += (1.0 - pole) * (missed - state[LOW_PASS])
        state[LEFT] = max(pole * state[LEFT], abs(missed - state[LOW_PASS]) / sizes.bandwidth)
        beyond = max(abs(miss[k]) - explained, 0.0)
        if v != 0.0:
            state[MEAN_SQUARE] += (beyond * beyond - state[MEAN_SQUARE]) / MEMORY
        state[PEAK] = max(pole * state[PEAK], beyond)
        state[SINCE] = period if position[k] != state[SHOWN] else state[SINCE] + period
        state[SHOWN] = position[k]
        seen = sizes.misfit * max(QUANTILE * math.sqrt(state[MEAN_SQUARE]), state[PEAK])
        off = max(MODEL_PART * state[LEFT], seen)
        half[k] = min(
            math.sqrt(rounding * rounding + off * off), PASSED * step / state[SINCE] + abs(v)
        )
