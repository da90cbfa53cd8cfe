"""Static error of the position in a hold (phase of constant reference)."""

from __future__ import annotations

import numpy as np

from frictool.metrics.final_value import final_value, tail_samples
from frictool.typing import Vector

MOVES = 2.0  # largest peak-to-peak change of the position of a resting axis, in sensor steps
# rounding error of the mean of positions that are multiples of an encoder step, relative to the
# largest position
ROUNDING = 16.0 * float(np.finfo(np.float64).eps)


def static_error(position: Vector, target: float, resolution: float = 0.0) -> float:
    """Return the static error [rad or m] from the positions (n,) of a hold.

    If the axis rests at the end of the hold, this is |target - final position|. The final position
    is the mean over the end of the hold (final_value.py). If the axis still moves by more than
    MOVES times `resolution`, the mean would hide an oscillation; the result is then the largest
    |target - position| at the end of the hold. `resolution` is the sensor's step [rad or m]. If it
    is unknown (0), the axis counts as resting.

    The rounding error of the positions is subtracted. An error of one encoder step therefore meets
    a limit of one encoder step.
    """
    end = position[-tail_samples(position.size) :]
    if moves(end, resolution):
        error = float(np.max(np.abs(target - end)))
    else:
        error = abs(target - final_value(position))
    return max(error - ROUNDING * max(abs(target), float(np.max(np.abs(end)))), 0.0)


def moves(end: Vector, resolution: float) -> bool:
    """Return True if the axis still moves, according to its positions (n,) at the end of a hold.

    `static_error` explains `resolution`.
    """
    return resolution > 0.0 and float(np.ptp(end)) > MOVES * resolution * (1.0 + 1e-6)
