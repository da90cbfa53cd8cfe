"""Rising static friction (thesis 2.3.2.1): a breakaway that grows with the time at rest.

    F_s(t) = full (1 - (1 - fresh) tau/(tau + t))      t: time at rest before the breakaway
                                                       (friction/rising_breakaway.py)

If tau is fixed, the law is linear in `full` and `full (1 - fresh)`; tau is searched. The law is
used only if it predicts breakaways left out of the fit better than a constant breakaway does. The
ramps must have different rates, because the time at rest hardly varies between ramps of the same
rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.identify.breakaway.position_law import as_good, left_out
from frictool.identify.fit_result import Interval
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.typing import Matrix, Vector

SPREAD = 3.0  # least ratio of the 95 % to the 5 % quantile of the times at rest
REACH = 3.0  # tau is searched from shortest time at rest / REACH to longest time * REACH


@dataclass(frozen=True)
class RisingFriction:
    """Breakaway that grows with the time at rest.

    - full: breakaway after a long rest, N m | N
    - fresh: breakaway just after a stop, divided by `full`
    - rise_time: time constant tau, s
    """

    full: Interval
    fresh: Interval
    rise_time: Interval


def rising_friction(
    rested: Vector, direction: Vector, friction: Vector, confidence: float
) -> RisingFriction | None:
    """Fit the growth of the breakaway with the time at rest.

    Return None if the times at rest hardly differ, if a constant breakaway predicts about as well,
    or if the breakaways do not determine a positive growth.

    - rested: time at rest before each breakaway, (n,), s
    - direction: direction of each breakaway, (n,), +1 or -1
    - friction: friction at each breakaway, (n,), N m | N
    """
    shortest, longest = np.quantile(rested, [0.05, 0.95])
    if longest < SPREAD * shortest:
        return None
    sides = np.column_stack([direction == side for side in np.unique(direction)]).astype(np.float64)
    offset = sides[:, 1:] - sides[:, :1]  # offset of the effort, if both directions are present

    def design(tau: float) -> Matrix:
        return np.column_stack((np.ones(rested.size), -tau / (tau + rested), offset))

    def squares(logarithm: float) -> float:
        rows = design(float(np.exp(logarithm)))
        return float(
            np.sum((friction - rows @ np.linalg.lstsq(rows, friction, rcond=None)[0]) ** 2)
        )

    logarithms = np.linspace(np.log(shortest / REACH), np.log(longest * REACH), 40)
    near = logarithms[int(np.argmin([squares(logarithm) for logarithm in logarithms]))]
    step = logarithms[1] - logarithms[0]
    tau = float(np.exp(bounded_minimum(squares, near - step, near + step)))
    rows = design(tau)
    if as_good(left_out(np.column_stack((rows[:, 0], offset)), friction), left_out(rows, friction)):
        return None
    value = np.linalg.lstsq(rows, friction, rcond=None)[0]
    moved = -value[1] * rested / (tau + rested) ** 2
    try:
        solution = solve(
            np.column_stack((rows, moved)),
            friction,
            np.ones(friction.size),
            np.arange(friction.size),
        )
    except SingularRegressors:
        return None
    half = solution.half_width(confidence)
    full, lost = float(value[0]), float(value[1])
    if not 0.0 < lost < full:
        return None
    fresh = 1.0 - lost / full
    reach = float(np.hypot(half[1], half[0] * lost / full)) / full
    return RisingFriction(
        Interval.around(full, half[0]),
        Interval(fresh, max(fresh - reach, 0.0), min(fresh + reach, 1.0)),
        Interval.around(tau, half[-1], 0.0),
    )
