"""The slowest pole of a controller, moved: to an exact integrator (5.4.3.1), or back inside where
the optimum has put it just outside.

A term r/(s - p) far below the bandwidth looks like r/s around it, wherever exactly p is: the
residue is kept, the pole is moved, and the loop is verified again like any other. W2's own pole,
which the plant's weight leaves in the controller, is the usual one.
"""

from __future__ import annotations

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, parallel_sum
from frictool.synth.realisation import first_order, split_pole

SLOW = 0.1  # of the bandwidth: a pole slower than this is slow


def with_integrator(k: Lti, bandwidth: float) -> Lti:
    """The controller with its slowest pole at 0, or at z = 1. bandwidth [rad/s].

    Raises NoSolutionError where no real pole is slower than a tenth of the bandwidth.
    """
    return moved(k, bandwidth, 1.0 if k.period else 0.0)


def stabilise_slow_pole(k: Lti, bandwidth: float, pole: float) -> Lti:
    """The controller as it is where it is stable; where only its slowest pole is not, with that
    pole at -`pole` [rad/s].

    Raises NoSolutionError where an unstable pole is not slow.
    """
    if k.stable:
        return k
    return moved(k, bandwidth, float(np.exp(-pole * k.period)) if k.period else -pole)


def moved(k: Lti, bandwidth: float, to: float) -> Lti:
    """The controller with its slowest pole at `to`, in the plane of its domain, and the residue as
    it is."""
    poles = np.linalg.eigvals(k.a).astype(np.complex128)
    rates = np.abs(poles - 1.0) / k.period if k.period else np.abs(poles)
    slowest = int(np.argmin(rates))
    pole, rate = poles[slowest], float(rates[slowest])
    if rate > SLOW * bandwidth or abs(pole.imag) > 1e-9 * max(1.0, abs(pole)):
        raise NoSolutionError(
            f"the slowest pole of the controller found is {rate:.3g} rad/s from an integrator, not below a tenth of the bandwidth "
            f"{bandwidth:.3g} rad/s: it cannot be moved; lower weights.static_error, or raise weights.command"
        )
    residue, rest = split_pole(k, float(pole.real))
    return parallel_sum(first_order(to, residue, k.period), rest)
