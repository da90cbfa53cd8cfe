"""The interval of what is partly a statistic and partly not known: a normal deviation, and ranges
within which anything is as likely.

A range that dominates gives the share `confidence` of itself, and not 1.96/sqrt(3) = 1.13 of it,
which would always hold: the distribution of the sum is inverted from its characteristic function
(Gil-Pelaez),

    P(|X| < h) = 2/pi int_0^inf sin(h t)/t  e^(-deviation^2 t^2/2)  prod_k sinc(r_k t) dt
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtri

GRID = 4000
NARROW = 1e-2  # of the sum: a normal part below it is taken for so much, so that the integral ends
TAIL = 9.0  # of the normal part's frequency: e^(-TAIL^2/2) is nothing


def half_width(confidence: float, deviation: float, ranges: Sequence[float]) -> float:
    """Half the width of the central interval of a normal `deviation` plus uniform variables within
    +- each of `ranges`, same unit."""
    halves = np.array([abs(r) for r in ranges if r != 0.0])
    total = float(np.sqrt(deviation**2 + np.sum(halves**2) / 3.0))
    if halves.size == 0 or total == 0.0:
        return float(ndtri(0.5 + 0.5 * confidence)) * deviation
    sigma, halves = max(deviation / total, NARROW), halves / total
    t = (np.arange(GRID) + 0.5) * TAIL / sigma / GRID
    weight = (
        np.exp(-0.5 * (sigma * t) ** 2) * np.prod(np.sinc(np.outer(halves, t) / np.pi), axis=0) / t
    )
    step = t[1] - t[0]

    def short(h: float) -> float:
        return float(2.0 / np.pi * step * np.sum(np.sin(h * t) * weight)) - confidence

    return total * float(brentq(short, 1e-3, 12.0))
