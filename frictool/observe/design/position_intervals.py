"""Position intervals with nearly constant friction (thesis 6.15 to 6.17).

In each interval, the friction must be monotone, so that it stays between the values at the ends.
Each extremum is therefore an end of two intervals. A monotone section between two extrema is
divided into intervals with equal change of friction. Delta_f is half the range of the friction in
an interval. The numbers of intervals of the sections are chosen such that the largest Delta_f is as
small as possible.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.documents.observer import FrictionMap
from frictool.errors import NoSolutionError
from frictool.friction.polynomial_minimum import sign_changes
from frictool.observe.design.friction_map import friction_at

FLAT = 1e-9  # range of the friction, relative to its mean, below which friction is constant


@dataclass(frozen=True)
class FrictionInterval:
    """Interval [low, high] [rad | m] with mean friction f_m and deviation Delta_f [N m | N]."""

    low: float
    high: float
    friction: float
    deviation: float


def intervals(friction: FrictionMap, direction: int, count: int) -> list[FrictionInterval]:
    """Return `count` position intervals of one direction, in ascending order.

    If the friction is constant, the only interval is the whole travel. Raises NoSolutionError if
    `count` is less than the number of monotone sections.
    """
    edges = turning_points(friction, direction)
    levels = friction_at(friction, direction, np.array(edges))
    spread = np.abs(np.diff(levels))
    if np.max(spread) <= FLAT * np.mean(levels):
        return [FrictionInterval(edges[0], edges[-1], float(np.mean(levels)), 0.0)]
    if count < len(spread):
        inner = ", ".join(f"{edge:.4g}" for edge in edges[1:-1])
        raise NoSolutionError(
            f"--intervals {count}: the friction must be monotone in each interval, but the "
            f"{'forward' if direction > 0 else 'backward'} friction has an extremum at {inner} "
            f"{friction.over.unit}; allowed: at least {len(spread)}"
        )
    shares = [1] * len(spread)
    while sum(shares) < count:
        shares[int(np.argmax(spread / np.array(shares)))] += 1
    cut = [edges[0]]
    for (low, high), share in zip(itertools.pairwise(edges), shares, strict=True):
        cut += [
            *(_where(friction, direction, low, high, part / share) for part in range(1, share)),
            high,
        ]
    return [_interval(friction, direction, low, high) for low, high in itertools.pairwise(cut)]


def turning_points(friction: FrictionMap, direction: int) -> list[float]:
    """Return the positions [rad | m] of the travel's ends and of the friction's extrema."""
    powers = friction.forward if direction > 0 else friction.backward
    low, high = friction.over.low, friction.over.high
    slope = [power * value for power, value in enumerate(powers)][1:]
    # a zero at which the slope keeps its sign is removed below
    edges = [low, *(root for root in sign_changes(slope, low, high) if low < root < high), high]
    levels = friction_at(friction, direction, np.array(edges))
    steps = np.diff(levels)
    return [
        low,
        *(
            edge
            for edge, before, after in zip(edges[1:-1], steps[:-1], steps[1:], strict=True)
            if before * after < 0.0
        ),
        high,
    ]


def _where(friction: FrictionMap, direction: int, low: float, high: float, part: float) -> float:
    """Return the position at which the friction has changed by the fraction `part` (0 to 1).

    The fraction refers to the change of the friction from position `low` to position `high`.
    """
    first, last = (float(friction_at(friction, direction, end)) for end in (low, high))
    return float(
        scipy.optimize.brentq(
            lambda x: float(friction_at(friction, direction, x)) - (first + part * (last - first)),
            low,
            high,
        )
    )


def _interval(friction: FrictionMap, direction: int, low: float, high: float) -> FrictionInterval:
    first, last = (float(friction_at(friction, direction, end)) for end in (low, high))
    return FrictionInterval(low, high, 0.5 * (first + last), 0.5 * abs(last - first))
