"""Point-to-point profile with bounded speed, acceleration and jerk, computed sample by sample.

    w  = d - T/2 v                     distance d to the target, less the motion of T/2 at speed v
    v* = sign(w) |w|/T                 |w| <= a T^2/2          braking law, |v*| <= speed
       = sign(w) (sqrt(2 a |w|) - a T/2)   else, |v*| <= speed
    v+ = v* within v - a T ... v + a T,     d+ = d - T/2 (v + v+)
    p  = r - d+,   f = mean of p over N samples                smoothing

a is the largest acceleration, T the sample period, r the reference; + marks values at this sample.
The braking law v*(w) is the largest speed from which the axis can stop at its target if the speed
changes by at most a T per sample. In the square-root part of the law, v+ = v - a T; in the linear
part, two samples end the motion. If |d+| <= END a T^2 and |v+| <= END a T with END = 1/256, both
are set to 0. The target may change at any sample, also in motion. A move takes at most three
samples longer than `duration`, which is the time of the time-optimal trapezoid plus N - 1 samples
for the mean.

The mean over N samples limits the jerk to 2 a/(N T) and delays the end of the move by N - 1
samples. Sources: Zanasi, Lo Bianco, Tonielli, Automatica 36 (2000) 439-448 (discrete-time filter in
closed loop); Biagiotti, Melchiorri, Control Eng. Practice 20 (2012) 1385-1399 (cascade with a
moving average).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from frictool.control.program import Program, ProgramNode

END = 1.0 / 256.0  # fraction of a T and a T^2 below which a speed and a distance are set to 0


class ProfileLimits(NamedTuple):
    """Limits of a profile: speed [rad/s | m/s], acceleration [rad/s^2 | m/s^2].

    smoothing_samples: number N of samples of the moving average, at least 2.
    """

    speed: float
    acceleration: float
    smoothing_samples: int

    def jerk(self, period: float) -> float:
        """Return the largest jerk [rad/s^3 | m/s^3] for a sample period [s]."""
        return 2.0 * self.acceleration / (self.smoothing_samples * period)


def profile(
    program: Program, reference: ProgramNode, limits: ProfileLimits, period: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return the profile's position [rad | m] and speed [rad/s | m/s] at this sample."""
    program.block("profile: the speed from which the target can still be reached by braking")
    top = limits.speed
    per_sample = limits.acceleration * period
    beyond = 0.5 * top * top / limits.acceleration + 2.0 * top * period
    low, high = reference.low - beyond, reference.high + beyond
    last = program.last("reference", reference, "position")
    before = program.state("profile_distance", -(high - low), high - low)
    speeds = [
        program.state(f"profile_speeds[{k}]", -top, top)
        for k in range(limits.smoothing_samples - 1)
    ]
    zero = program.constant(0.0)
    half = program.constant(0.5 * period, "profile_half_period")
    change = program.constant(per_sample, "profile_speed_change")
    distance = before + (reference - last)
    ahead = program.named("profile_ahead", distance - half * speeds[0])
    wanted = _braking_law(program, ahead, limits, period)
    speed = program.smaller(program.larger(wanted, speeds[0] - change), speeds[0] + change)
    left = distance - half * (speeds[0] + speed)
    ended = (abs(left) <= program.constant(END * per_sample * period, "profile_end_distance")) & (
        abs(speed) <= program.constant(END * per_sample, "profile_end_speed")
    )
    speed = program.named("profile_speed", program.select(ended, zero, speed))
    left = program.named("profile_left", program.select(ended, zero, left))
    program.update("profile_distance", left)
    for k, value in enumerate([speed, *speeds[:-1]]):
        program.update(f"profile_speeds[{k}]", value)
    position, mean = _smoothed(program, reference - left, [speed, *speeds], period)
    program.state("filtered_before", low, high, start="position")
    program.update("filtered_before", position)
    program.state("filtered_speed_before", -top, top)
    program.update("filtered_speed_before", mean)
    return position, mean


def _braking_law(
    program: Program, ahead: ProgramNode, limits: ProfileLimits, period: float
) -> ProgramNode:
    top = limits.speed
    double = 2.0 * limits.acceleration
    corner = 0.5 * limits.acceleration * period
    size = program.smaller(
        abs(ahead), program.constant((top + corner) ** 2 / double, "profile_braking_distance")
    )
    root = program.sqrt(
        program.constant(double, "profile_double_acceleration") * size
    ) - program.constant(corner, "profile_corner_speed")
    line = program.constant(1.0 / period, "per_period") * size
    near = size <= program.constant(corner * period, "profile_corner_distance")
    speed = program.smaller(
        program.select(near, line, root), program.constant(top, "profile_top_speed")
    )
    return program.select(ahead < program.constant(0.0), -speed, speed)


def _smoothed(
    program: Program,
    position: ProgramNode,
    speeds: list[ProgramNode],
    period: float,
) -> tuple[ProgramNode, ProgramNode]:
    """Return the means of the profile's position and speed over the last N samples.

    speeds[k] is k samples old. The mean position is the present position minus the sum over k of
    c_k speeds[k]. With the period T, c_0 = T/2 (N - 1)/N and c_k = T (2 N - 1 - 2 k)/(2 N).
    """
    samples = len(speeds)
    program.block(f"profile: mean over {samples} samples, which bounds the jerk")
    weights = [
        program.constant(
            period * (samples - 1 if k == 0 else 2 * samples - 1 - 2 * k) / (2 * samples),
            f"profile_lag[{k}]",
        )
        for k in range(samples)
    ]
    share = program.constant(1.0 / samples, "profile_share")
    missing = program.dot(weights, speeds)
    mean = program.dot([share] * samples, speeds)
    return program.named("filtered", position - missing), program.named("filtered_speed", mean)


def duration(distance: float, limits: ProfileLimits, period: float) -> float:
    """Return the time [s] of a time-optimal trapezoid of speed over `distance`, plus N - 1 samples.

    N is the number of samples of the moving average.
    """
    top, most = limits.speed, limits.acceleration
    accelerated = top * top / most
    moved = abs(distance)
    trapezoid = 2.0 * math.sqrt(moved / most) if moved <= accelerated else moved / top + top / most
    return trapezoid + (limits.smoothing_samples - 1) * period
