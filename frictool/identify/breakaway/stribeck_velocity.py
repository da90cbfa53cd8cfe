"""Stribeck velocities that agree with the changes of the encoder after the onsets.

Friction falls from the breakaway to Coulomb friction over the speed (2.34). The slower it falls,
the later the encoder shows the motion: an onset that is corrected for a fall at once gives a
breakaway that is too high. The changes tell the Stribeck velocity as far as the encoder is fine.
`allowed_fall` keeps each velocity whose misfit is at most the quantile of chi-square with one
degree of freedom above the least misfit. The misfit is the mean over the onsets: a test that
repeats itself repeats its errors of timing, so all onsets count as one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

GRID = np.geomspace(
    0.02, 20.0, 24
)  # Stribeck velocities relative to the speed at which the ramp alone passes a count

Misfit = Callable[[float], float]  # Stribeck velocity in rad/s | m/s -> mean misfit of an onset


@dataclass(frozen=True)
class StribeckVelocityRange:
    """Stribeck velocity of the breakaway's value, and the range that its interval holds, rad/s |
    m/s.

    0: friction falls at once; inf: it does not fall. known: the range comes from another log, and
    not from the ramps' onsets.
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
    nominal : misfit with the axis's most likely parameters.
    ends : misfit with one parameter each at an end of its interval.
    scale : speed at which the ramp alone passes a count, rad/s | m/s.
    confidence : of the quantile, 0 to 1.

    Returns
    -------
    The range reaches to the next velocity of the grid that is refused. Its value is a fall at once
    where that is allowed, else the velocity with the least misfit.
    """
    velocities = [0.0, *(scale * GRID).tolist(), math.inf]
    found = [nominal(velocity) for velocity in velocities]
    limit = min(found) + float(ndtri(0.5 + 0.5 * confidence)) ** 2
    allowed = [
        k
        for k, velocity in enumerate(velocities)
        if found[k] <= limit or any(misfit(velocity) <= limit for misfit in ends)
    ]
    best = 0.0 if found[0] <= limit else velocities[int(np.argmin(found))]
    return StribeckVelocityRange(
        best,
        velocities[max(allowed[0] - 1, 0)],
        velocities[min(allowed[-1] + 1, len(velocities) - 1)],
    )
