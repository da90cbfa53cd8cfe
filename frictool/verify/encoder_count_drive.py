"""What one encoder count asks of the drive, from the coefficients that run on the target."""

from __future__ import annotations

import numpy as np

from frictool.plant.lti import Lti

HORIZON = 10  # samples; later the loop has answered


def count_current(controller: Lti, step: float, horizon: int = HORIZON) -> float:
    """The largest drive [A or V] over `horizon` samples after the position moved by one count of
    `step` [rad or m], at rest before.

    The first sample is |d| step, what comes at once; a lead in the controller may ask for more a
    sample later. What the integral adds beyond the horizon is left to the loop. Raises ValueError
    for a controller in continuous time.
    """
    if not controller.period:
        raise ValueError("the current of one count is that of a sampled controller")
    x, largest = np.zeros((controller.order, 1)), 0.0
    for _ in range(horizon):
        largest = max(largest, float(np.max(np.abs(controller.c @ x + controller.d))))
        x = controller.a @ x + controller.b
    return largest * step
