"""Approximation of a curve by straight lines within a tolerance, by cone intersection."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def cone_indices(times: Vector, values: Vector, tolerance: float) -> NDArray[np.intp]:
    """Return indices of samples whose connecting lines stay within `tolerance` of the curve.

    The indices do not decrease, but an index may occur twice. Samples that are not finite are kept.
    """
    count = times.size
    kept = np.empty(3 * count, dtype=np.intp)
    kept[0] = 0
    used = 1
    low, high = -math.inf, math.inf
    for k in range(1, count):
        start = kept[used - 1]
        step = times[k] - times[start]
        rise = values[k] - values[start]
        if math.isfinite(rise) and step > 0.0 and not low <= rise / step <= high:
            start = k - 1
            kept[used] = start
            used += 1
            step = times[k] - times[start]
            rise = values[k] - values[start]
            low, high = -math.inf, math.inf
        if math.isfinite(rise) and step > 0.0:
            low = max(low, (rise - tolerance) / step)
            high = min(high, (rise + tolerance) / step)
            continue
        for index in (k - 1, k):
            kept[used] = index
            used += 1
        low, high = -math.inf, math.inf
    kept[used] = count - 1
    return kept[: used + 1]
