"""Precision of the breakaway from ramps (4.3), before they are played.

The encoder shows a motion when the axis reaches the next edge, a distance s of at most one count.
Without a drop of friction, that takes t = (6 inertia s/R)^(1/3) after the onset, while the ramp of
R [N m/s | N/s] grows by R t. `identify` subtracts the mean delay. The remaining errors are the
spread of s, which averages out over onsets, and the effect of the inertia's range, which remains.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# standard deviation of s^(1/3) for s uniform in 0 to 1
SPREAD = math.sqrt(3.0 / 5.0 - (3.0 / 4.0) ** 2)


class RampPrecision(NamedTuple):
    """Precision of the breakaway, N m | N.

    - latest: largest excess of the ramp at a visible onset
    - deviation: standard deviation of the corrected mean of all onsets
    """

    latest: float
    deviation: float


def ramp_precision(
    rate: float, step: float, period: float, inertia: tuple[float, float, float], onsets: float
) -> RampPrecision:
    """Return the precision of ramps.

    - rate: slope of the ramps, N m/s | N/s
    - step: encoder step, rad | m
    - period: sample period, s
    - inertia: lower end, value, upper end
    - onsets: number of onsets
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
