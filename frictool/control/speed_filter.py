"""The measured speed that braking looks at: the encoder's difference through a first-order low-pass sampled by Tustin.

v[k] = a v[k-1] + b0 u[k] + b1 u[k-1],   u[k] = (y[k] - y[k-1]) 1/T
"""

from __future__ import annotations

from frictool.kernels import kernel


def speed_filter_coefficients(bandwidth: float, period: float) -> tuple[float, float, float]:
    """(a, b0, b1) from the bandwidth [rad/s] and the sample period [s]; 0 leaves the difference as it is."""
    if bandwidth == 0.0:
        return 0.0, 1.0, 0.0
    x = bandwidth * period
    gain = x / (2.0 + x)
    return (2.0 - x) / (2.0 + x), gain, gain


@kernel
def speed_filter_step(a: float, b0: float, b1: float, speed: float, difference: float, previous: float) -> float:
    """The measured speed at this sample from the last one and the encoder's differences [rad/s | m/s] of this sample and the last."""
    return a * speed + b0 * difference + b1 * previous
