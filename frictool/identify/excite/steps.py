"""Steps of the position over the travel, for validation: half sines with pauses between them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import PlannedStroke
from frictool.identify.excite.excitation_sequence import check_samples
from frictool.identify.excite.half_sines import Motion, half_sine, joined, reachable_speed
from frictool.identify.excite.sine import longest_distance

# positions relative to the distance: long and short steps in both directions
LEVELS = (0.0, 1.0, 0.0, 0.6, 0.2, 0.5, 0.4)
REST = 0.5  # s, pause after each step


def steps(limits: BenchLimits, period: float, amplitude: float | None, repetitions: int) -> Motion:
    """Return position, velocity and acceleration (n,) of steps through the positions LEVELS.

    The levels are repeated `repetitions` times. `amplitude` [rad | m] is half the distance between
    the outermost levels.
    """
    distance = 2.0 * amplitude if amplitude else longest_distance(limits)
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    levels = middle + distance * (np.array(LEVELS + LEVELS[:1]) - 0.5)
    moves = [
        (start, end, reachable_speed(limits, abs(end - start))) for start, end in pairwise(levels)
    ]
    lasting = sum(
        REST + PlannedStroke(speed, abs(end - start)).duration for start, end, speed in moves
    )
    check_samples(repetitions * lasting, period)
    parts = []
    for start, end, speed in moves * repetitions:
        parts += [half_sine(start, end, speed, period), _rest(end, period)]
    return joined(parts, float(levels[-1]))


def _rest(position: float, period: float) -> Motion:
    still = np.zeros(max(1, round(REST / period)))
    return still + position, still, still
