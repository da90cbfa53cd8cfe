"""Order reduction of a controller by one state at a time, with a check after each reduction.

Balanced truncation removes the states with the smallest Hankel singular values. The error of the
reduced controller is at most twice the sum of these values (Enns 1984; Glover 1984), and the direct
gain is unchanged. Residualisation (singular perturbation) has the same error bound. It leaves the
steady state unchanged, but changes the direct gain. The bound applies to the controller, not to the
closed loop. The caller therefore passes a function that checks the loop with each reduced
controller, and raises NoSolutionError if the check fails. An integrator is split off first and not
reduced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, parallel_sum
from frictool.synth.balancing import balanced_form
from frictool.synth.realisation import split_integrator

Check = Callable[[Lti], None]
# preserved frequencies: truncation keeps the direct gain, residualisation the steady state
Kept = Literal["high", "low"]


@dataclass(frozen=True)
class ReducedController:
    """Reduced controller that passed the check of its loop.

    `bound`: upper bound of the H-infinity norm of the original minus the reduced controller.
    """

    controller: Lti
    bound: float


def reduce_order(k: Lti, order: int, check: Check, kept: Kept = "high") -> list[ReducedController]:
    """Return checked controllers of falling order, from the order of `k` minus 1 down to `order`.

    kept: `high` leaves the direct gain unchanged, `low` the steady state. `check` is called with
    each reduced controller and raises NoSolutionError if the loop is not acceptable; `reduce_order`
    adds the order to the message of this error. `reduce_order` also raises NoSolutionError if `k`
    without its integrator is unstable, or if `order` is 0 and `k` has an integrator.
    """
    integrator, rest = split_integrator(k)
    integrators = 0 if integrator is None else 1
    if not rest.stable:
        raise NoSolutionError(
            "order reduction: the controller is unstable; allowed: one integrator and stable poles"
        )
    if order < integrators:
        raise NoSolutionError(
            "order reduction: found order 0; allowed: 1 or more, because the integrator is kept"
        )
    balanced, hankel = balanced_form(rest)
    steps: list[ReducedController] = []
    for states in range(min(rest.order, k.order) - 1, order - integrators - 1, -1):
        part = (truncated if kept == "high" else residualised)(balanced, min(states, len(hankel)))
        smaller = part if integrator is None else parallel_sum(integrator, part)
        try:
            check(smaller)
        except NoSolutionError as error:
            raise NoSolutionError(f"reduced to order {states + integrators}: {error}") from None
        steps.append(ReducedController(smaller, float(2.0 * np.sum(hankel[states:]))))
    return steps


def truncated(k: Lti, order: int) -> Lti:
    """Return the balanced system `k` truncated to its first `order` states."""
    return Lti(k.a[:order, :order], k.b[:order], k.c[:, :order], k.d, k.period)


def residualised(k: Lti, order: int) -> Lti:
    """Return the balanced system `k` reduced to its first `order` states by residualisation.

    The other states are replaced by their steady values.
    """
    kept = slice(0, order)
    gone = slice(order, k.order)
    settled = (
        np.eye(k.order - order) * (1.0 if k.period else 0.0) - k.a[gone, gone]
    )  # x_gone = settled^-1 (a21 x + b2 u)
    by_state = np.linalg.solve(settled, k.a[gone, kept])
    by_input = np.linalg.solve(settled, k.b[gone])
    return Lti(
        k.a[kept, kept] + k.a[kept, gone] @ by_state,
        k.b[kept] + k.a[kept, gone] @ by_input,
        k.c[:, kept] + k.c[:, gone] @ by_state,
        k.d + k.c[:, gone] @ by_input,
        k.period,
    )
