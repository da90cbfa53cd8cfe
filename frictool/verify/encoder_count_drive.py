"""Largest drive that one encoder count causes at rest, from the coefficients as stored."""

from __future__ import annotations

import numpy as np

from frictool.plant.lti import Lti

HORIZON = 10  # samples; afterwards the loop has reacted


def drive_after_count(controller: Lti, step: float, horizon: int = HORIZON) -> float:
    """Return the largest |drive| [A | V] after a displacement by one encoder count from rest.

    - step: size of an encoder count [rad | m]
    - horizon: number of samples over which the maximum is taken; a controller with lead may request
      more drive at the second sample than at the first

    Raises ValueError for a controller in continuous time.
    """
    if not controller.period:
        raise ValueError("the drive after one count is defined for a sampled controller only")
    x = np.zeros((controller.order, 1))
    largest = 0.0
    for _ in range(horizon):
        largest = max(largest, float(np.max(np.abs(controller.c @ x + controller.d))))
        x = controller.a @ x + controller.b
    return largest * step
