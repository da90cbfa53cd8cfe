"""A chain of second-order sections as one system: what runs on the target where a controller's form is sos.

Transposed direct form II, section by section, what leaves one enters the next:

    y = b0 u + s1        s1+ = s2 + b1 u - a1 y        s2+ = b2 u - a2 y
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.plant.lti import Lti

Matrix = NDArray[np.float64]


def chain(sections: Sequence[Sequence[float]], period: float) -> Lti:
    """The system of sections b0 b1 b2 a0 a1 a2, a0 = 1; states s1, s2 of each section in the chain's order. period [s]."""
    n = 2 * len(sections)
    leaving = np.zeros(n + 1)  # what leaves the section before, as a row over (states, input); at first the input itself
    leaving[n] = 1.0
    rows = np.zeros((n, n + 1))
    for place, (b0, b1, b2, _, a1, a2) in zip(range(0, n, 2), sections, strict=True):
        entering, leaving = leaving, b0 * leaving
        leaving[place] += 1.0
        rows[place] = b1 * entering - a1 * leaving
        rows[place, place + 1] += 1.0
        rows[place + 1] = b2 * entering - a2 * leaving
    return Lti(rows[:, :n], rows[:, n:], leaving[None, :n], leaving[None, n:], period)
