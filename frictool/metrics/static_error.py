"""Static error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.metrics.final_value import final_value


def static_error(position: NDArray[np.float64], target: float) -> float:
    """|reference - final position| of a hold (n,), rad or m. Signed offsets left and right of the
    reference count alike."""
    return abs(target - final_value(position))
