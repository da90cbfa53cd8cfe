"""Many questions, one rate of false answers: Holm's correction (Scandinavian Journal of Statistics
6, 1979)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def holm_corrected(chances: Vector) -> Vector:
    """Probabilities (q,) of q questions, corrected: to believe those below a level is wrong
    anywhere at most at that rate, dependent or not.
    """
    order = np.argsort(chances, kind="stable")
    raised = np.minimum(
        1.0, np.maximum.accumulate(chances[order] * (chances.size - np.arange(chances.size)))
    )
    found = np.empty_like(chances)
    found[order] = raised
    return found
