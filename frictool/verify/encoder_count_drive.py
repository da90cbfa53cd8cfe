"""Drive requested after one encoder count, from the coefficients that run on the target."""

from __future__ import annotations

import numpy as np

from frictool.plant.lti import Lti

HORIZON = 10  # samples; later the loop has reacted


def count_current(controller: Lti, step: float, horizon: int = HORIZON) -> float:
    """Return the largest drive [A or V] after a move of one count from rest.

    `step` is one count [rad or m]; the maximum is over `horizon` samples. The first sample is |d|
    step; a lead in the controller may request more one sample later. The integral's later
    contribution is not counted. Raises ValueError for a controller in continuous time.
    """
    if not controller.period:
        raise ValueError("the drive after one count is defined for a sampled controller only")
    x = np.zeros((controller.order, 1))
    largest = 0.0
    for _ in range(horizon):
        largest = max(largest, float(np.max(np.abs(controller.c @ x + controller.d))))
        x = controller.a @ x + controller.b
    return largest * step
