"""Savitzky-Golay weights, equal to the result of `scipy.signal.savgol_coeffs`.

The weights are computed here because the import of `scipy.signal` takes 0.7 s, as long as the
identification of a log.
"""

from __future__ import annotations

import math

import numpy as np
import scipy

from frictool.typing import Vector


def savitzky_golay(
    window: int, degree: int, derivative: int, period: float, *, last_first: bool = False
) -> Vector:
    """Return the weights of a derivative at the middle of a window.

    These weights have the smallest norm of all weights that are exact for polynomials up to
    `degree`.

    Parameters
    ----------
    window : int
        Number of samples.
    degree : int
        Degree of the polynomial, below `window`.
    derivative : int
        Order d of the derivative.
    period : float
        Time between samples [s].
    last_first : bool, optional
        True for the order of `numpy.convolve`: the weight of the last sample is first.

    Returns
    -------
    array, shape (window,)
        The weights [1/s^d]; their product with the samples is the derivative.
    """
    offsets = np.arange(window) - 0.5 * (window - 1)
    if last_first:
        offsets = offsets[::-1]
    powers = offsets ** np.arange(degree + 1.0)[:, None]
    moments = np.zeros(degree + 1)
    moments[derivative] = math.factorial(derivative) / period**derivative
    negligible = np.finfo(np.float64).eps * max(powers.shape)
    weights, *_ = scipy.linalg.lstsq(powers, moments, cond=negligible)
    return np.asarray(weights, dtype=np.float64)
