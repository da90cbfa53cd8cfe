"""Static error of a hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.final_value import final_value


def static_error(position: NDArray[np.float64], target: float) -> float:
    """Return |reference - final position| [rad or m] of a hold (n,).

    The sign does not count: offsets left and right of the reference are treated alike.
    """
    return abs(target - final_value(position))
