"""Holm's correction for multiple tests (Scandinavian Journal of Statistics 6, 1979)."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def holm_corrected(chances: Vector) -> Vector:
    """Return the corrected p-values (q,) of q tests.

    If each hypothesis with a corrected p-value below a level is rejected, the probability of a
    false rejection is at most this level, also for dependent tests.
    """
    order = np.argsort(chances, kind="stable")
    raised = np.minimum(
        1.0, np.maximum.accumulate(chances[order] * (chances.size - np.arange(chances.size)))
    )
    corrected = np.empty_like(chances)
    corrected[order] = raised
    return corrected
