"""Replacement of a controller's slowest pole by an integrator or by a stable pole.

With an integrator (thesis 5.4.3.1) the static error vanishes. If the slowest pole of the optimal
controller is slightly unstable, a stable pole replaces it. A pole p with the residue r
contributes r/(s - p), which is close to r/s at frequencies far above |p|. The pole can therefore be
moved if the residue is unchanged. The loop is then verified again. Usually the slow pole is the
pole of W2, which is a part of the weighted plant and thus of the controller.
"""

from __future__ import annotations

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, parallel_sum
from frictool.synth.realisation import first_order, split_pole

SLOW = 0.1  # share of the bandwidth below which a pole is slow


def with_integrator(k: Lti, bandwidth: float) -> Lti:
    """Return the controller `k` with its slowest pole moved to s = 0 or z = 1.

    bandwidth: bandwidth of the loop [rad/s]. Raises NoSolutionError if the slowest pole is complex
    or not slower than a tenth of the bandwidth.
    """
    return moved(k, bandwidth, 1.0 if k.period else 0.0)


def stabilise_slow_pole(k: Lti, bandwidth: float, pole: float) -> Lti:
    """Return the controller `k`, with its slowest pole moved to s = -`pole` if `k` is unstable.

    Raises NoSolutionError if `k` is unstable and its slowest pole is complex or not slow compared
    with the bandwidth.
    """
    if k.stable:
        return k
    return moved(k, bandwidth, float(np.exp(-pole * k.period)) if k.period else -pole)


def moved(k: Lti, bandwidth: float, to: float) -> Lti:
    """Return the controller `k` with its slowest pole moved to `to` (in s or z).

    Raises NoSolutionError if the slowest pole is complex or not slow compared with the bandwidth.
    """
    poles = np.linalg.eigvals(k.a).astype(np.complex128)
    rates = np.abs(poles - 1.0) / k.period if k.period else np.abs(poles)
    slowest = int(np.argmin(rates))
    pole = poles[slowest]
    rate = float(rates[slowest])
    if rate > SLOW * bandwidth or abs(pole.imag) > 1e-9 * max(1.0, abs(pole)):
        raise NoSolutionError(
            f"the slowest controller pole is {rate:.3g} rad/s from an integrator; allowed: real, "
            f"below a tenth of the bandwidth of {bandwidth:.3g} rad/s; lower weights.static_error "
            "or raise weights.command"
        )
    residue, rest = split_pole(k, float(pole.real))
    return parallel_sum(first_order(to, residue, k.period), rest)
