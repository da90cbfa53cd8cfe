"""Prefilter of the position reference (thesis 5.69), H = 1/(s^2/w0^2 + 2 m s/w0 + 1), by Tustin.

    f' = v,   v' = w0^2 (r - f) - 2 m w0 v        f filtered reference, v its speed, r reference

w0 is the natural frequency [rad/s], m the damping ratio, and T the sample period. The trapezoidal
rule with h = T/2, applied to both equations, gives f and v at the new sample. Therefore f[k] -
f[k-1] = h (v[k] + v[k-1]) holds exactly, and v = 0 shows that f has settled. If f = r and v = 0, f
and v stay exactly constant until r changes.

Properties: unit gain, delay 2 m/w0, overshoot exp(-pi m/sqrt(1 - m^2)) (1.5 % at m = 0.8). Rule
(section 5.4.3.2 of the thesis): w0 = 6/(specified response time) and m = 0.8; the bandwidth of the
loop should be higher.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.control.difference_equation import impulse_sums
from frictool.control.program import Program, ProgramNode


def prefilter_coefficients(
    natural_frequency: float, damping: float, period: float
) -> tuple[float, float, float]:
    """Return (h, p, q) of v[k] = p v[k-1] + q (r[k] + r[k-1] - 2 f[k-1]) with h = T/2.

    r is the reference, f the filtered reference, v the speed of f, and T the sample period [s].
    """
    h = 0.5 * period
    friction = 2.0 * damping * natural_frequency * h
    stiffness = natural_frequency * natural_frequency * h * h
    denominator = 1.0 + friction + stiffness
    return (
        h,
        (1.0 - friction - stiffness) / denominator,
        natural_frequency * natural_frequency * h / denominator,
    )


def prefilter(
    program: Program,
    reference: ProgramNode,
    natural_frequency: float,
    damping: float,
    period: float,
) -> tuple[ProgramNode, ProgramNode]:
    """Return the filtered reference [rad | m] and its speed [rad/s | m/s] at this sample."""
    program.block("prefilter of the reference (5.69), sampled by Tustin in state form")
    h, p, q = prefilter_coefficients(natural_frequency, damping, period)
    low, high, top = bounds(reference.low, reference.high, natural_frequency, damping, period)
    last = program.last("reference", reference, "position")
    filtered_before = program.state("filtered_before", low, high, start="position")
    speed_before = program.state("filtered_speed_before", -top, top)
    pressed = (reference + last) - program.constant(2.0) * filtered_before
    speed = (
        program.constant(p, "prefilter_p") * speed_before
        + program.constant(q, "prefilter_q") * pressed
    )
    program.named("filtered_speed", speed)
    filtered = program.named(
        "filtered", filtered_before + program.constant(h, "prefilter_h") * (speed + speed_before)
    )
    program.update("filtered_before", filtered)
    program.update("filtered_speed_before", speed)
    return filtered, speed


def bounds(
    low: float, high: float, natural_frequency: float, damping: float, period: float
) -> tuple[float, float, float]:
    """Return (low, high, speed): bounds of the filtered reference [rad | m] and of its |speed|.

    The speed is in rad/s | m/s. The bounds are valid for every reference between the arguments
    `low` and `high`.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return -math.inf, math.inf, math.inf
    h, p, q = prefilter_coefficients(natural_frequency, damping, period)
    # impulse response of the sampled form for the states f, v/w0 and the last r; its absolute sum
    # is the largest response to |r| <= 1
    w = natural_frequency
    a = np.array(
        [[1.0 - 2.0 * h * q, h * (1.0 + p) * w, h * q], [-2.0 * q / w, p, q / w], [0.0, 0.0, 0.0]]
    )
    reach, speed, _ = 0.5 * (high - low) * impulse_sums(a, np.array([h * q, q / w, 1.0]))
    middle = 0.5 * (low + high)
    return middle - float(reach), middle + float(reach), w * float(speed)
