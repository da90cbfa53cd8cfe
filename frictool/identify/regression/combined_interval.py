"""Interval of the sum X of a normal variable and of uniform variables with known ranges.

If one range +-r dominates, the half width is `confidence` times r. The distribution of X follows
from its characteristic function (Gil-Pelaez):

    P(|X| < h) = 2/pi int_0^inf sin(h t)/t  e^(-deviation^2 t^2/2)  prod_k sinc(r_k t) dt

h is the half width, `deviation` the standard deviation of the normal variable, +-r_k are the ranges
of the uniform variables, and sinc(x) = sin(x)/x.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from frictool.plant.root_search import sign_change

GRID = 4000
NARROW = 1e-2  # least deviation relative to the sum of all parts, so that the integral converges
TAIL = 9.0  # upper limit of the integral, in units of 1/deviation; e^(-TAIL^2/2) is negligible


def half_width(confidence: float, deviation: float, ranges: Sequence[float]) -> float:
    """Return the half width of an interval that contains a sum with the probability `confidence`.

    The sum contains a normal variable with standard deviation `deviation`, and a uniform variable
    within +-r for each r in `ranges`, all in the same unit.
    """
    halves = np.array([abs(r) for r in ranges if r != 0.0])
    total = float(np.sqrt(deviation**2 + np.sum(halves**2) / 3.0))
    if halves.size == 0 or total == 0.0:
        return float(scipy.special.ndtri(0.5 + 0.5 * confidence)) * deviation
    sigma = max(deviation / total, NARROW)
    halves = halves / total
    t = (np.arange(GRID) + 0.5) * TAIL / sigma / GRID
    weight = (
        np.exp(-0.5 * (sigma * t) ** 2) * np.prod(np.sinc(np.outer(halves, t) / np.pi), axis=0) / t
    )
    step = t[1] - t[0]

    def short(h: float) -> float:
        return float(2.0 / np.pi * step * np.sum(np.sin(h * t) * weight)) - confidence

    return total * sign_change(short, 1e-3, 12.0)
