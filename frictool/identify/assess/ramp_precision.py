"""How precisely breakaway ramps give the breakaway (4.3), before they are played.

The encoder shows a motion when the axis has gone on to its next edge: anywhere in a count, t = (6
inertia s/R)^(1/3) after an onset without any drop of friction, in which the ramp of R [N m/s | N/s]
went on by R t. `identify` takes the mean lateness off. What is left is its spread over the place in
the count, which onsets average, and what the range of the inertia makes of it, which they do not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

SPREAD = math.sqrt(3.0 / 5.0 - (3.0 / 4.0) ** 2)  # of s^(1/3), s uniform on 0..1


class RampPrecision(NamedTuple):
    """N m | N. latest: by which an onset is seen late at most. deviation: of the mean of all
    onsets, corrected."""

    latest: float
    deviation: float


def ramp_precision(
    rate: float, step: float, period: float, inertia: tuple[float, float, float], onsets: float
) -> RampPrecision:
    """rate [N m/s | N/s], step [rad | m], period [s], inertia: low, value, high."""
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
