"""Rule for ties: of several values that agree within a relative tolerance, the first is chosen.

Vertices that differ only in friction have the same modulus margin. The last digits of the margins
depend on the processor. Without a rule, the choice of the worst vertex would also depend on the
processor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

TOLERANCE = 1e-5  # relative; ten times the tolerance of an H-infinity norm (verify/hinf_norm.py)


def largest(values: Iterable[float], tolerance: float = TOLERANCE) -> tuple[float, int]:
    """Return (largest value, index of the first value that agrees with the largest).

    Parameters
    ----------
    values : iterable of float
        At least one number. NaN is ignored unless all values are NaN.
    tolerance : float
        Tolerance relative to the largest value. An infinite value agrees only with an equal value.

    Raises
    ------
    ValueError
        If there is no value.

    Examples
    --------
    >>> largest([1.0, 2.0 - 1e-9, 2.0])
    (2.0, 1)
    """
    numbers = [-math.inf if math.isnan(value) else float(value) for value in values]
    top = max(numbers)
    margin = tolerance * abs(top) if math.isfinite(top) else 0.0
    return top, next(
        index for index, value in enumerate(numbers) if value == top or top - value <= margin
    )


def smallest(values: Iterable[float], tolerance: float = TOLERANCE) -> tuple[float, int]:
    """Return (smallest value, index of the first value that agrees with the smallest).

    `largest` explains the arguments.

    Examples
    --------
    >>> smallest([3.0, 1.0 + 1e-9, 1.0])
    (1.0, 1)
    """
    negated, index = largest((-value for value in values), tolerance)
    return -negated, index
