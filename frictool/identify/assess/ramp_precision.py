"""Expected precision of the breakaway from ramps (thesis 4.3).

A motion is visible when the axis reaches the next encoder edge, after a distance s of at most one
count. If the effort is a ramp of R [N m/s | N/s] and friction does not drop at the onset, the axis
reaches the edge after the time t = (6 inertia s/R)^(1/3). In this time, the effort grows by R t.
`identify` subtracts the mean of this growth. Two errors remain: an error due to the scatter of s,
which averages out over the onsets, and an error due to the assumed inertia, which does not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# standard deviation of s^(1/3) for s uniform in 0 to 1
SPREAD = math.sqrt(3.0 / 5.0 - (3.0 / 4.0) ** 2)


class RampPrecision(NamedTuple):
    """Precision of the breakaway, N m | N.

    - latest: largest excess of the effort over the breakaway when the motion becomes visible
    - deviation: standard deviation of the mean breakaway of all onsets, after subtraction of the
      mean excess
    """

    latest: float
    deviation: float


def ramp_precision(
    rate: float, step: float, period: float, inertia: tuple[float, float, float], onsets: float
) -> RampPrecision:
    """Return the precision of the breakaway from ramps.

    - rate: slope of the ramps, N m/s | N/s
    - step: encoder step, rad | m
    - period: sample period, s
    - inertia: lower end, value and upper end of the inertia's interval, kg m^2 | kg
    - onsets: number of breakaways
    """
    low, value, high = inertia
    latest = (6.0 * value * step) ** (1.0 / 3.0) * rate ** (2.0 / 3.0)
    scatter = math.hypot(SPREAD * latest, rate * period / math.sqrt(12.0)) / math.sqrt(onsets)
    common = (
        0.75
        * latest
        * ((high / value) ** (1.0 / 3.0) - (low / value) ** (1.0 / 3.0))
        / math.sqrt(12.0)
    )
    return RampPrecision(latest, math.hypot(scatter, common))
