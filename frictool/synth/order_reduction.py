"""Order reduction of a controller by one state at a time; the caller verifies each step.

Balanced truncation drops the states that the input reaches least and the output sees least. Its
error is at most twice the sum of the dropped Hankel singular values (Enns 1984; Glover 1984), and
it keeps the direct gain. Residualisation (singular perturbation) has the same bound and keeps the
steady state instead. The bound holds for the controller alone. Its effect on the loop is known only
after verification, so a failed check is an error and not a warning. An integrator is split off
first and kept.
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
Kept = Literal[
    "high", "low"
]  # frequencies preserved: truncation keeps the direct gain, residualisation the steady state


@dataclass(frozen=True)
class ReducedController:
    """Controller that passed the check.

    `bound` limits the norm of its difference from the original controller.
    """

    controller: Lti
    bound: float


def reduce_order(k: Lti, order: int, check: Check, kept: Kept = "high") -> list[ReducedController]:
    """Return `k` with one state less at a time down to `order`; each passes `check`.

    `check` raises NoSolutionError if a controller fails; the error then names the order. Raises
    NoSolutionError also if the controller, apart from an integrator, is unstable, or if `order` is
    below that of the integrator.
    """
    integrator, rest = split_integrator(k)
    held = 0 if integrator is None else 1
    if not rest.stable:
        raise NoSolutionError(
            "order reduction: the controller is unstable; only the stable part of one can be "
            "reduced"
        )
    if order < held:
        raise NoSolutionError(
            "order reduction: order 0 is below the integrator, which is kept; take order: 1 or more"
        )
    balanced, hankel = balanced_form(rest)
    steps: list[ReducedController] = []
    for states in range(min(rest.order, k.order) - 1, order - held - 1, -1):
        part = (truncated if kept == "high" else residualised)(balanced, min(states, len(hankel)))
        smaller = part if integrator is None else parallel_sum(integrator, part)
        try:
            check(smaller)
        except NoSolutionError as error:
            raise NoSolutionError(f"reduced to order {states + held}: {error}") from None
        steps.append(ReducedController(smaller, float(2.0 * np.sum(hankel[states:]))))
    return steps


def truncated(k: Lti, order: int) -> Lti:
    """Return the first `order` states of a balanced system."""
    return Lti(k.a[:order, :order], k.b[:order], k.c[:, :order], k.d, k.period)


def residualised(k: Lti, order: int) -> Lti:
    """Return the first `order` states of a balanced system; the others take their steady state."""
    kept, gone = slice(0, order), slice(order, k.order)
    settled = (
        np.eye(k.order - order) * (1.0 if k.period else 0.0) - k.a[gone, gone]
    )  # x_gone = settled^-1 (a21 x + b2 u)
    by_state, by_input = (
        np.linalg.solve(settled, k.a[gone, kept]),
        np.linalg.solve(settled, k.b[gone]),
    )
    return Lti(
        k.a[kept, kept] + k.a[kept, gone] @ by_state,
        k.b[kept] + k.a[kept, gone] @ by_input,
        k.c[:, kept] + k.c[:, gone] @ by_state,
        k.d + k.c[:, gone] @ by_input,
        k.period,
    )
