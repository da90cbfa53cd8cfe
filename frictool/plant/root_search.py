"""Root search: argument at which a function changes its sign, without scipy.optimize.

The import of scipy.optimize takes a quarter of a second, longer than the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable


def sign_change(
    value: Callable[[float], float], low: float, high: float, tolerance: float = 1e-13
) -> float:
    """Return the argument at which `value` changes its sign, by Ridders' method (1979).

    Parameters
    ----------
    value
        Continuous function with opposite signs at `low` and `high`.
    low, high
        Ends of the searched interval.
    tolerance
        Relative tolerance of the result.

    Returns
    -------
    float
        The argument at the sign change; `high` if `value` has the same sign at both ends.
    """
    before, after = value(low), value(high)
    if before == 0.0:
        return low
    if after == 0.0 or (before < 0.0) == (after < 0.0):
        return high
    last = math.inf
    while True:
        middle = 0.5 * (low + high)
        at = value(middle)
        if at == 0.0 or not low < middle < high:
            return middle
        shift = (middle - low) / math.sqrt(1.0 - (before / at) * (after / at))
        root = middle + (shift if (at < 0.0) == (before < 0.0) else -shift)
        if not low < root < high:  # the values differ by many powers of ten
            root = middle
        beyond = value(root)
        if beyond == 0.0 or abs(root - last) <= tolerance * abs(root):
            return root
        last = root
        for place, found in ((middle, at), (root, beyond)):
            if (found < 0.0) == (before < 0.0):
                if place > low:
                    low, before = place, found
            elif place < high:
                high, after = place, found
