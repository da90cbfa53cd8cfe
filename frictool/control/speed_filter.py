"""The measured speed: difference quotient of the encoder through a low-pass filter (thesis 5.70).

    order 1   v = w u/(s + w)                              u = (y[k] - y[k-1])/T
    order 2   v = u/(s^2/w^2 + 2 s/w + 1), two equal poles

y is the measured position, T the sample period, and w the bandwidth. Thesis (5.70) is order 2 with
the derivative s y in place of u. The filter is sampled by Tustin's rule. Properties: the lag is T/2
+ 1/w (order 1) or T/2 + 2/w (order 2). One encoder count causes a peak of u of (encoder step)/T;
the peak of v is about w (encoder step). Rule (section 5.4.3.2 of the thesis): w is ten times w0 of
the prefilter. The verification of the loop includes this lag.
"""

from __future__ import annotations

from frictool.control.program import Program, ProgramNode


def first_order(bandwidth: float, period: float) -> tuple[float, float]:
    """Return (a, b) of v[k] = a v[k-1] + b (u[k] + u[k-1]).

    u is the input and v the output of the filter.

    - bandwidth: bandwidth w [rad/s]
    - period: sample period [s]
    """
    x = bandwidth * period
    return (2.0 - x) / (2.0 + x), x / (2.0 + x)


def velocity(
    program: Program, motion: ProgramNode, period: float, bandwidth: float, order: int
) -> ProgramNode:
    """Return the filtered measured speed [rad/s | m/s].

    - motion: change of the position since the last sample [rad | m]
    - period: sample period [s]
    - bandwidth: bandwidth of the low-pass filter [rad/s]; 0 means no filter
    - order: order of the low-pass filter, 1 or 2
    """
    program.block(
        "measured speed: the encoder's difference"
        + ("" if bandwidth == 0.0 else ", low-pass by Tustin" + " (5.70)" * (order == 2))
    )
    one, other = motion.args
    widest = max(abs(one.high - other.low), abs(one.low - other.high)) / period
    speed = program.constant(1.0 / period, "rate") * motion
    if bandwidth == 0.0:
        return program.named("speed", speed)
    a, b = first_order(bandwidth, period)
    pole, gain = program.constant(a, "speed_filter_a"), program.constant(b, "speed_filter_b")
    for stage in range(order):
        suffix = "" if stage == order - 1 else "_raw"
        entered = program.state(f"difference_before{suffix}", -widest, widest)
        before = program.state(f"speed_before{suffix}", -widest, widest)
        program.named(f"difference{suffix}", speed)
        program.update(f"difference_before{suffix}", speed)
        speed = program.named(f"speed{suffix}", pole * before + gain * (speed + entered))
        program.update(f"speed_before{suffix}", speed)
    return speed
