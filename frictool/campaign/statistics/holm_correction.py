"""Holm's correction for multiple tests (Scandinavian Journal of Statistics 6, 1979)."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector


def holm_corrected(chances: Vector) -> Vector:
    """Return the corrected p-values (q,) of q tests.

    Let all hypotheses be rejected whose corrected p-value is below a level. The probability of any
    false rejection is then at most this level, even if the tests depend on each other.
    """
    order = np.argsort(chances, kind="stable")
    raised = np.minimum(
        1.0, np.maximum.accumulate(chances[order] * (chances.size - np.arange(chances.size)))
    )
    corrected = np.empty_like(chances)
    corrected[order] = raised
    return corrected
