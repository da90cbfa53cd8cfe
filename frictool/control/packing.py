"""A controller document as the flat parameters that `cascade` runs on. The only place of this room that knows a document."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.control.prefilter import prefilter_coefficients
from frictool.control.speed_filter import speed_filter_coefficients
from frictool.documents.controller import Controller


def pack(controller: Controller) -> NDArray[np.float64]:
    """The parameters of `cascade.control_step` (m,), in SI, laid out as that file's constants say."""
    law, speed, period = controller.position_law, controller.linear, controller.sample_period_s
    prefilter = (0.0, 0.0, 0.0)
    if controller.prefilter is not None:
        prefilter = prefilter_coefficients(controller.prefilter.natural_frequency_rad_s, controller.prefilter.damping, period)
    matrices = speed.discrete
    head = [
        len(matrices.a),
        period,
        controller.drive_limit,
        law.gain,
        law.gain / np.sqrt(law.band),
        law.band,
        law.action == "brake",
        law.settled_speed,
        law.rest_speed,
        controller.prefilter is not None,
        *prefilter,
        *speed_filter_coefficients(controller.velocity.bandwidth_rad_s, period),
        1.0 / period,
    ]
    rows = [value for matrix in (matrices.a, matrices.b, matrices.c, matrices.d) for row in matrix for value in row]
    return np.array([*head, *rows, *speed.anti_windup], dtype=np.float64)
