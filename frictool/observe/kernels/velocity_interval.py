"""Half width of the 95 % interval of an estimated velocity at each sample.

    half^2 = (1.96 ROUNDED G_n step/sqrt(12))^2 + max(1.2 h, 1.96 G_a s, G_a r)^2
    half is at most 2 step/(time since the last count) + |v|

    G_n, G_a   velocity error per position error: fields `rounding` and `misfit` of `ErrorGains`
               (observe/design/error_gains.py)
    ROUNDED    fraction of a count's rounding error that passes the observer's dead zone
    h          predicted error |delta_a - low-pass of delta_a|/w with the bandwidth w;
               delta_a = unsure a + friction sign(v) is the possible error of the model's
               acceleration a (unsure, friction: VelocityIntervalConstants). The disturbance
               estimate compensates a constant delta_a; a change of delta_a acts for about 1/w
    s          observed error: rms of (measured - predicted position) beyond the rounding error,
               over about MEMORY samples in motion
    r          peak of the observed error, for example after an impact; r decays as fast as the
               observer's error

h and G_a times the observed error are two estimates of one velocity error; the larger estimate is
used. ROUNDED and the factor 1.2 are explained in docs/theory/velocity.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

QUANTILE = 1.959964  # quantile of the normal distribution for an interval at 95 %
ROUNDED = 0.75  # fraction of a count's rounding error that passes the observer's dead zone
MODEL_PART = 1.2  # weight of the predicted error h
# largest speed relative to one count per time since the last count; 2 if the speed rises steadily
# from 0 (the axis moves by at most one count)
PASSED = 2.0
MEMORY = 100.0  # samples, time constant of the mean square of the observed error
# indices of `state`: low-pass of delta_a, predicted error [rad/s | m/s], time since the last count
# [s], last position, mean square and peak of the observed error
LOW_PASS, LEFT, SINCE, SHOWN, MEAN_SQUARE, PEAK, STATE_SIZE = 0, 1, 2, 3, 4, 5, 6


class VelocityIntervalConstants(NamedTuple):
    """Constants of the velocity's interval.

    - unsure: relative uncertainty of the inertia
    - friction: (uncertainty of the dry friction)/inertia [rad/s2 | m/s2]
    - step: encoder step [rad | m]
    - cell: dead zone of the observer [rad | m]
    - bandwidth: observer's bandwidth [rad/s]
    - period: sample period [s]
    - rounding, misfit: fields of `ErrorGains` [1/s]
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
    """Fill `half` (n,) with the half widths of the velocity's interval [rad/s | m/s].

    - velocity: estimated velocity, (n,), rad/s | m/s
    - acceleration: acceleration of the model, (n,), rad/s^2 | m/s^2
    - position: measured position, (n,), rad | m
    - miss: innovation (measured minus predicted position) reduced by the dead zone, (n,), rad | m
    - state: values between samples, in the order of the module's constants, (6,); updated in place
    """
    step, period = sizes.step, sizes.period
    pole = math.exp(-sizes.bandwidth * period)
    rounding = QUANTILE * ROUNDED * sizes.rounding * step / math.sqrt(12.0)
    explained = max(0.5 * (step - sizes.cell), 0.0)  # part of a miss that rounding explains
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
