"""Where the load behind a backlash is, told from the motor's position.

|motor - load| <= backlash/2, and within it the load rests where it is (2.2.4, (4.45)): the load is
the play operator of the motor's position. It is increasing in the unknown place in the gap at the
start and in the position, and moves by no more than either does, so that the ends of what is
unknown bound it. A stroke longer than the backlash takes the load along: from there on the bounds
are as far apart as the sensor's step and the backlash's own interval leave them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def load_bounds(
    position: NDArray[np.float64], backlash: float, unsure: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest position (n,) [rad or m] of the load, for motor positions (n,) and a
    `backlash` of full width [rad or m].

    unsure [rad or m]: by how much a position may be wrong, and half of the width by which the
    backlash may be.
    """
    half = 0.5 * backlash
    low = _play(position, half, float(position[0]) - half)
    high = _play(position, half, float(position[0]) + half)
    return low - unsure, high + unsure


def _play(position: NDArray[np.float64], half: float, start: float) -> NDArray[np.float64]:
    """The play operator: y[k] is the nearest to y[k-1] within `half` of position[k]."""
    load, out = start, []
    for value in position.tolist():
        load = min(max(load, value - half), value + half)
        out.append(load)
    return np.array(out)
