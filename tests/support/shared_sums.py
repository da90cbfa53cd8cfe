"""A function to share among machines, whose last bits tell the order of its sums."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray


def spectrum(seed: int) -> NDArray[np.float64]:
    """Eigenvalues (40,) of a drawn matrix, after a while that is long enough to be ended in."""
    time.sleep(0.02)
    drawn = np.random.default_rng(seed).normal(size=(40, 40))
    return np.linalg.svd(drawn @ drawn.T, compute_uv=False)
