"""Range of Stribeck velocities that agree with the logged motion after breakaways.

With increasing speed, friction decreases from the breakaway to Coulomb friction (thesis 2.34). If
friction decreases slowly, the encoder shows the motion later. The computed breakaway is then too
high if friction is assumed to drop immediately.

The misfit of an onset of motion is the sum of the squared differences between computed and logged
travel, divided by their variance (`onset_friction`). The mean misfit over all onsets is computed
for pairs of Stribeck velocity and exponent. The smallest mean misfit with the preferred exponent is
the reference. A pair is allowed if the mean misfit of the pair exceeds the reference by at most the
chi-square quantile with one degree of freedom. The mean replaces the sum, because timing errors are
the same at every onset of a repetitive test. The value of the breakaway comes from pairs with the
preferred exponent. The other pairs can imitate friction that varies with position; they widen the
interval of the breakaway.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import scipy

# Stribeck velocities relative to the speed after one count if only the ramp accelerates the axis
GRID = np.geomspace(0.02, 20.0, 24)
EXPONENTS = (2.0, 1.0, 0.5)  # exponents of the Stribeck curve in fits, the preferred one first


class StribeckFall(NamedTuple):
    """Stribeck curve: decrease of friction with the speed v from breakaway to Coulomb friction.

    The decrease is proportional to 1 - exp(-(v/velocity)^exponent). `velocity` is the Stribeck
    velocity, rad/s | m/s; 0 if friction drops immediately, inf if friction does not decrease.
    """

    velocity: float
    exponent: float = EXPONENTS[0]


IMMEDIATE = StribeckFall(0.0)
NO_FALL = StribeckFall(math.inf)


class Misfit(Protocol):
    """Function that returns the mean misfit of the onsets of motion for a Stribeck curve.

    The misfit of an onset compares computed and logged travel (module docstring).
    """

    def __call__(self, fall: StribeckFall, most: float) -> float:
        """Return the misfit averaged over the onsets, or inf if the average exceeds `most`."""


@dataclass(frozen=True)
class StribeckVelocityRange:
    """Stribeck curves with which a breakaway and its interval are computed.

    - value: Stribeck curve with which the value of the breakaway is computed
    - ends: Stribeck curves at the ends of the allowed range; the interval of the breakaway contains
      the values computed with these curves
    - known: True if the range comes from another log and not from the onsets
    """

    value: StribeckFall
    ends: tuple[StribeckFall, ...]
    known: bool = False

    @property
    def velocity(self) -> float:
        """Return the Stribeck velocity of `value`, rad/s | m/s."""
        return self.value.velocity

    @property
    def low(self) -> float:
        """Return the smallest Stribeck velocity of `ends`, rad/s | m/s."""
        return min(end.velocity for end in self.ends)

    @property
    def high(self) -> float:
        """Return the largest Stribeck velocity of `ends`, rad/s | m/s."""
        return max(end.velocity for end in self.ends)


def allowed_fall(
    nominal: Misfit, ends: Sequence[Misfit], scale: float, confidence: float
) -> StribeckVelocityRange:
    """Return the range of Stribeck curves that agree with the logged motion after breakaways.

    Parameters
    ----------
    nominal
        Misfit function for the most likely parameters of the axis.
    ends
        Misfit functions for axes with one parameter at an end of its interval.
    scale
        Speed after one count if only the ramp accelerates the axis, rad/s | m/s.
    confidence
        Confidence of the chi-square quantile, 0 to 1.

    Returns
    -------
    StribeckVelocityRange
        For each exponent, `ends` contains the grid velocities just below and just above the allowed
        range. If the Stribeck velocity 0 is allowed, `value` has this velocity. Otherwise, `value`
        is the curve with the preferred exponent and the smallest misfit.
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

    def is_allowed(fall: StribeckFall) -> bool:
        return levels[fall] <= limit or any(misfit(fall, limit) <= limit for misfit in ends)

    included: list[StribeckFall] = []
    for column in columns:
        # curves between the outermost allowed curves are not examined
        first = next((k for k, fall in enumerate(column) if is_allowed(fall)), None)
        if first is not None:
            last = next(k for k in reversed(range(len(column))) if is_allowed(column[k]))
            included += [column[max(first - 1, 0)], column[min(last + 1, len(column) - 1)]]
    value = IMMEDIATE if levels[IMMEDIATE] <= limit else best
    return StribeckVelocityRange(value, tuple(dict.fromkeys(included)))
