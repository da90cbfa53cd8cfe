"""Stribeck velocities that agree with the encoder's changes after the onsets.

Friction falls from the breakaway to Coulomb friction over the speed (2.34). The slower it falls,
the later the encoder shows the motion. An onset that is corrected for an immediate fall then gives
too high a breakaway. The finer the encoder, the better its changes determine the Stribeck velocity.

`allowed_fall` keeps each velocity whose misfit exceeds the least misfit by at most the chi-square
quantile with one degree of freedom. The misfit is the mean over the onsets: a repetitive test
repeats its timing errors, so that all onsets count as one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

# Stribeck velocities relative to the speed at which the ramp alone passes a count
GRID = np.geomspace(0.02, 20.0, 24)

Misfit = Callable[[float], float]  # Stribeck velocity in rad/s | m/s -> mean misfit of an onset


@dataclass(frozen=True)
class StribeckVelocityRange:
    """Stribeck velocity of the breakaway's value, and its range in the interval, rad/s | m/s.

    At velocity 0, friction falls at once; at inf, it does not fall. `known` is True if
    the range comes from another log and not from the ramps' onsets.
    """

    velocity: float
    low: float
    high: float
    known: bool = False


def allowed_fall(
    nominal: Misfit, ends: Sequence[Misfit], scale: float, confidence: float
) -> StribeckVelocityRange:
    """Return the range of Stribeck velocities that the onsets allow.

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
        The range extends to the next rejected velocity of the grid. The value is an immediate fall
        if that is allowed, else the velocity with the least misfit.
    """
    velocities = [0.0, *(scale * GRID).tolist(), math.inf]
    levels = [nominal(velocity) for velocity in velocities]
    limit = min(levels) + float(ndtri(0.5 + 0.5 * confidence)) ** 2
    allowed = [
        k
        for k, velocity in enumerate(velocities)
        if levels[k] <= limit or any(misfit(velocity) <= limit for misfit in ends)
    ]
    best = 0.0 if levels[0] <= limit else velocities[int(np.argmin(levels))]
    return StribeckVelocityRange(
        best,
        velocities[max(allowed[0] - 1, 0)],
        velocities[min(allowed[-1] + 1, len(velocities) - 1)],
    )
