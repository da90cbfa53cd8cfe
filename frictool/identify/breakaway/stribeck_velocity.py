"""Falls of friction over speed that agree with the encoder's changes after the onsets.

Friction falls from the breakaway to Coulomb friction over the speed (2.34). The slower it falls,
the later the encoder shows the motion. An onset that is corrected for an immediate fall then gives
too high a breakaway. The finer the encoder, the better its changes determine the fall.

`allowed_fall` keeps each pair of Stribeck velocity and exponent whose misfit exceeds the least
misfit of the preferred exponent by at most the chi-square quantile with one degree of freedom. The
other exponents widen the interval and do not change the value: they can imitate friction that
varies with position. The misfit is the mean over
the onsets: a repetitive test repeats its timing errors, so that all onsets count as one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import scipy

# Stribeck velocities relative to the speed at which the ramp alone passes a count
GRID = np.geomspace(0.02, 20.0, 24)
EXPONENTS = (2.0, 1.0, 0.5)  # exponents of a Stribeck curve that fits try, the preferred one first


class StribeckFall(NamedTuple):
    """Fall of friction by 1 - exp(-(v/velocity)^exponent).

    At velocity 0, friction falls at once; at inf, it does not fall. The velocity is in rad/s | m/s.
    """

    velocity: float
    exponent: float = EXPONENTS[0]


IMMEDIATE = StribeckFall(0.0)
NO_FALL = StribeckFall(math.inf)


class Misfit(Protocol):
    """Function that compares the onsets with a fall, for given parameters of the axis."""

    def __call__(self, fall: StribeckFall, most: float) -> float:
        """Return the misfit averaged over the onsets, or inf if the average exceeds `most`."""


@dataclass(frozen=True)
class StribeckVelocityRange:
    """Fall of the breakaway's value, and the falls in its interval.

    - value: fall with which the breakaway is computed
    - ends: falls whose breakaways the interval includes
    - known: the range comes from another log and not from the ramps' onsets
    """

    value: StribeckFall
    ends: tuple[StribeckFall, ...]
    known: bool = False

    @property
    def velocity(self) -> float:
        """Return the Stribeck velocity of the breakaway's value, rad/s | m/s."""
        return self.value.velocity

    @property
    def low(self) -> float:
        """Return the least Stribeck velocity in the interval, rad/s | m/s."""
        return min(end.velocity for end in self.ends)

    @property
    def high(self) -> float:
        """Return the largest Stribeck velocity in the interval, rad/s | m/s."""
        return max(end.velocity for end in self.ends)


def allowed_fall(
    nominal: Misfit, ends: Sequence[Misfit], scale: float, confidence: float
) -> StribeckVelocityRange:
    """Return the range of falls that the onsets allow.

    Parameters
    ----------
    nominal
        Misfit with the axis's most likely parameters.
    ends
        Misfits with one parameter each at an end of its interval.
    scale
        Speed at which the ramp alone passes a count, rad/s | m/s.
    confidence
        Confidence of the chi-square quantile, 0 to 1.

    Returns
    -------
    StribeckVelocityRange
        For each exponent, the range extends to the next rejected velocity of the grid. The value
        is an immediate fall if that is allowed, else the fall of the preferred exponent with the
        least misfit.
    """
    columns = [
        [IMMEDIATE, *(StribeckFall(scale * step, exponent) for step in steps.tolist()), NO_FALL]
        for exponent, steps in zip(EXPONENTS, (GRID, GRID[::2], GRID[::2]), strict=True)
    ]
    margin = float(scipy.special.ndtri(0.5 + 0.5 * confidence)) ** 2
    levels: dict[StribeckFall, float] = {}
    limit = math.inf
    for fall in columns[0]:
        levels[fall] = nominal(fall, limit)
        limit = min(limit, levels[fall] + margin)
    best = min(columns[0], key=levels.__getitem__)
    for fall in itertools.chain(*columns[1:]):
        if fall not in levels:
            levels[fall] = nominal(fall, limit)
    included: list[StribeckFall] = []
    for column in columns:
        allowed = [
            k
            for k, fall in enumerate(column)
            if levels[fall] <= limit or any(misfit(fall, limit) <= limit for misfit in ends)
        ]
        if allowed:
            included += [column[max(allowed[0] - 1, 0)]]
            included += [column[min(allowed[-1] + 1, len(column) - 1)]]
    value = IMMEDIATE if levels[IMMEDIATE] <= limit else best
    return StribeckVelocityRange(value, tuple(dict.fromkeys(included)))
