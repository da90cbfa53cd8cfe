"""Rising static friction (2.3.2.1): the breakaway grows with the time at rest, which ramps of
several rates tell.

    F_s(t) = full (1 - (1 - fresh) tau/(tau + t))        t: time at rest before the breakaway
                                                         (friction/rising_breakaway.py)

Linear in full and in full (1 - fresh) for a given tau, which is searched. The law has to predict
breakaways left out better than a constant. A single rate does not do: t is then the same for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from frictool.identify.breakaway.position_law import as_good, left_out
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import Vector
from frictool.identify.regression.regression import Matrix, SingularRegressors, solve

SPREAD = 3.0  # of the times at rest, 95 % over 5 %
REACH = 3.0  # how far beyond the times at rest tau is looked for


@dataclass(frozen=True)
class RisingFriction:
    """`full`: the breakaway after a long rest, N m | N; `fresh`: just after a stop, over it;
    `rise_time` tau in s."""

    full: Interval
    fresh: Interval
    rise_time: Interval


def rising_friction(
    rested: Vector, direction: Vector, friction: Vector, confidence: float
) -> RisingFriction | None:
    """The law over `rested` (n,) in s of breakaways `friction` (n,) in either `direction` (n,), or
    None where a constant does."""
    shortest, longest = np.quantile(rested, [0.05, 0.95])
    if longest < SPREAD * shortest:
        return None
    sides = np.column_stack([direction == side for side in np.unique(direction)]).astype(np.float64)
    offset = sides[:, 1:] - sides[:, :1]  # an offset of the effort, where both directions are there

    def design(tau: float) -> Matrix:
        return np.column_stack((np.ones(rested.size), -tau / (tau + rested), offset))

    def squares(place: float) -> float:
        rows = design(float(np.exp(place)))
        return float(
            np.sum((friction - rows @ np.linalg.lstsq(rows, friction, rcond=None)[0]) ** 2)
        )

    places = np.linspace(np.log(shortest / REACH), np.log(longest * REACH), 40)
    near = places[int(np.argmin([squares(place) for place in places]))]
    step = places[1] - places[0]
    tau = float(
        np.exp(minimize_scalar(squares, bounds=(near - step, near + step), method="bounded").x)
    )
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
    fresh, reach = 1.0 - lost / full, float(np.hypot(half[1], half[0] * lost / full)) / full
    return RisingFriction(
        Interval(full, full - float(half[0]), full + float(half[0])),
        Interval(fresh, max(fresh - reach, 0.0), min(fresh + reach, 1.0)),
        Interval(tau, max(tau - float(half[-1]), 0.0), tau + float(half[-1])),
    )
