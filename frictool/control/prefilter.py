"""Prefilter of the position reference (5.69): H = 1/(s^2/w0^2 + 2 m s/w0 + 1), sampled by Tustin in state form.

    f' = v,   v' = w0^2 (r - f) - 2 m w0 v        f filtered reference, v its speed, r reference

The trapezoidal rule with h = T/2 solves both lines for the new sample. v is the derivative of f in the sense of that rule,
f[k] - f[k-1] = h (v[k] + v[k-1]), which is why the band may wait for it. Where f = r and v = 0 nothing moves by a single bit.
"""

from __future__ import annotations

from frictool.kernels import kernel


def prefilter_coefficients(natural_frequency: float, damping: float, period: float) -> tuple[float, float, float]:
    """(h, p, q) of `prefilter_step` from w0 [rad/s], m [-] and the sample period [s]."""
    h = 0.5 * period
    friction = 2.0 * damping * natural_frequency * h
    stiffness = natural_frequency * natural_frequency * h * h
    denominator = 1.0 + friction + stiffness
    return h, (1.0 - friction - stiffness) / denominator, natural_frequency * natural_frequency * h / denominator


@kernel
def prefilter_step(h: float, p: float, q: float, filtered: float, speed: float, previous: float, reference: float) -> tuple[float, float]:
    """The filtered reference [rad | m] and its speed [per s] at this sample, from those of the last one and both references."""
    new_speed = p * speed + q * ((reference + previous) - 2.0 * filtered)
    return filtered + h * (new_speed + speed), new_speed
