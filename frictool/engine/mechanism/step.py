"""One step of the integrator with all modes held, and what may have ended within it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.ends import forces_hold
from frictool.engine.mechanism.field import field
from frictool.engine.mechanism.image import (
    BLOCKS,
    INNER,
    INNER_SIZE,
    SPEED,
)
from frictool.engine.mechanism.order_eight import NODES, STAGES, WEIGHTS, stage_point, step_end, step_errors
from frictool.engine.mechanism.state import AFTER, END, ERRORS, FIRST_POWER, INPUTS, POWER, SPENT, STUCK, THIRD, TRIAL, Room
from frictool.kernels import part_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

SLOW = 0.1  # of the speed that counts: slower ones are computed to the tolerance of this
PLACE_TIME = 1e-2  # s: positions are computed to the tolerance of a speed that counts, times this


@part_kernel
def try_step(
    k: Places,
    p: Vector,
    laws: Places,
    t: float,
    h: float,
    tolerance: float,
    y: Vector,
    modes: Places,
    room: Room,
) -> tuple[float, float]:
    """From y at t to END, with y' there in AFTER, the guards in TRIAL, what is done [J] in SPENT.

    Before: y' at t in slopes[0], the powers there in FIRST_POWER.

    Returns the error in tolerances, inf where the law or the mechanism fails, and the part of the step after which a force's guard was
    first seen broken, 1 where none was.
    """
    n, seen, failed = k[BLOCKS], 1.0, 0
    inputs, slopes, end, after, w = room.lines[INPUTS], room.slopes, room.lines[END], room.lines[AFTER], room.w
    guard, power, first_power, spent = room.lines[TRIAL], room.lines[POWER], room.lines[FIRST_POWER], room.lines[SPENT]
    for e in range(spent.shape[0]):
        spent[e] = h * WEIGHTS[0] * first_power[e]
    for stage in range(1, STAGES):
        stage_point(stage, h, y, slopes, end)
        failed += field(k, p, laws, t + NODES[stage] * h, end, modes, inputs, slopes[stage], w, guard, power)
        if WEIGHTS[stage] != 0.0:
            weight = h * WEIGHTS[stage]
            for e in range(spent.shape[0]):
                spent[e] += weight * power[e]
        if NODES[stage] < seen and not forces_hold(k, modes, guard):
            seen = NODES[stage]
    step_end(h, y, slopes, end)
    failed += field(k, p, laws, t + h, end, modes, inputs, after, w, guard, power)
    worst, errors = 0.0, room.lines[ERRORS]
    step_errors(h, slopes, errors, room.lines[THIRD])
    for i in range(n):
        if modes[i] != STUCK:
            size = max(SLOW * p[k[SPEED] + i], abs(end[n + i]))
            worst = max(worst, max(errors[i], errors[n + i] * PLACE_TIME) / (size * PLACE_TIME))
    for i in range(k[INNER]):
        worst = max(worst, errors[2 * n + i] / p[k[INNER_SIZE] + i])
    total = 0.0
    for i in range(y.shape[0]):
        total += end[i] + after[i]
    if failed != 0 or not math.isfinite(total) or not math.isfinite(worst):
        return math.inf, 1.0
    return worst / tolerance, seen
