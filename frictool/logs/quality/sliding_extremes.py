"""Largest value in a sliding window, as `scipy.ndimage.maximum_filter1d` computes it.

This module avoids the import of `scipy.ndimage`, which takes 0.2 s.
"""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def sliding_maximum(values: Vector, length: int, before: int) -> Vector:
    """Return the largest value in the window around each sample.

    Parameters
    ----------
    values : array, shape (n,)
        Signal, which is continued by reflection at both ends.
    length : int
        Number of samples of a window.
    before : int
        Number of samples in the window before the current sample.

    Returns
    -------
    array, shape (n,)
        Largest value in each window.
    """
    largest = np.pad(values, (before, length - 1 - before), mode="symmetric")
    reached = 1
    while reached < length:
        step = min(reached, length - reached)
        largest = np.maximum(largest[:-step], largest[step:])
        reached += step
    return largest
