"""A mass under a law with internal state (Dahl, LuGre, elasto-plastic, Leuven, Maxwell-slip): the reference models beside the exact engine.

    m v' = u(t, x, v, q) - F(z, z', v)        x' = v        q' = x - r        z' = rate(z, v)

These laws have no modes: v is small in their stick, never zero. Dormand-Prince with error control on v and z; where the contact is
stiff (z relaxes in microseconds at speed) the error itself keeps the step within the method's stability. A law's memory moves after an
accepted step only.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from frictool.engine.body import SAMPLE_EFFORT, SAMPLE_FRICTION, SAMPLE_MODE, SAMPLE_POSITION, SAMPLE_VELOCITY
from frictool.engine.dormand_prince import ERRORS, NODES, STAGES, TABLEAU, B
from frictool.engine.drive import effort, reference
from frictool.engine.status import LAW_FAILED, NOT_FINITE, OK, STEP_TOO_SMALL
from frictool.kernels import kernel

Vector = NDArray[np.float64]
Rate = Callable[[Vector, float, Vector, Vector], int]
Force = Callable[[Vector, Vector, float, Vector], float]
Commit = Callable[[Vector, float, Vector], int]

CONTACT = 3  # the state is (x, v, q, z...)
FIRST_STEP = 1e-9  # of the run
SHORTEST_STEP = 2.0**-50
GROWTH, SHRINKAGE, SAFETY = 5.0, 0.2, 0.9


@kernel
def _field(rate: Rate, force: Force, law: Vector, mass: float, drive: Vector, t: float, y: Vector, out: Vector) -> int:
    """Fills out with y'."""
    status = rate(y[CONTACT:], y[1], law, out[CONTACT:])
    out[0] = y[1]
    out[1] = (effort(t, y[0], y[1], y[2], drive) - force(y[CONTACT:], out[CONTACT:], y[1], law)) / mass
    out[2] = y[0] - reference(t, drive)
    return status


@kernel
def _try_step(
    rate: Rate,
    force: Force,
    law: Vector,
    mass: float,
    drive: Vector,
    t: float,
    h: float,
    y: Vector,
    slopes: Vector,
    scales: Vector,
    end: Vector,
) -> float:
    """One step of length h to `end`; slopes (7, n), the first row given. Returns the error in tolerances, inf where the law fails."""
    for i in range(1, STAGES):
        for row in range(y.shape[0]):
            total = 0.0
            for j in range(i):
                total += TABLEAU[i, j] * slopes[j, row]
            end[row] = y[row] + h * total
        if _field(rate, force, law, mass, drive, t + NODES[i] * h, end, slopes[i]) != OK:
            return math.inf
    worst = 0.0
    for row in range(1, y.shape[0]):
        if scales[row] > 0.0:
            error = 0.0
            for i in range(STAGES):
                error += ERRORS[i] * slopes[i, row]
            worst = max(worst, abs(h * error) / (scales[0] * max(scales[row], abs(y[row]), abs(end[row]))))
    return worst if math.isfinite(worst) and math.isfinite(end[1]) else math.inf


@kernel
def _between(y: Vector, slopes: Vector, h: float, share: float, out: Vector) -> None:
    """The dense output at the share of the step."""
    for row in range(y.shape[0]):
        total = 0.0
        for i in range(STAGES):
            total += slopes[i, row] * share * (B[i, 0] + share * (B[i, 1] + share * (B[i, 2] + share * B[i, 3])))
        out[row] = y[row] + h * total


@kernel
def _sample(rate: Rate, force: Force, law: Vector, drive: Vector, t: float, y: Vector, zdot: Vector, row: Vector) -> None:
    rate(y[CONTACT:], y[1], law, zdot)
    row[SAMPLE_POSITION], row[SAMPLE_VELOCITY], row[SAMPLE_EFFORT] = y[0], y[1], effort(t, y[0], y[1], y[2], drive)
    row[SAMPLE_FRICTION] = force(y[CONTACT:], zdot, y[1], law)
    row[SAMPLE_MODE] = float(np.sign(y[1]))


@kernel
def _factor(error: float) -> float:
    """How much longer or shorter the next step is than one of this error, in tolerances."""
    if not math.isfinite(error):
        return SHRINKAGE
    return GROWTH if error == 0.0 else min(GROWTH, max(SHRINKAGE, SAFETY * error**-0.2))


@kernel
def _segment(
    rate: Rate,
    force: Force,
    commit: Commit,
    law: Vector,
    mass: float,
    y: Vector,
    scales: Vector,
    drive: Vector,
    t: float,
    end: float,
    times: Vector,
    samples: Vector,
    filled: int,
) -> tuple[int, float, int]:
    """Under one drive up to `end`: status, the time reached, samples filled so far."""
    n = y.shape[0]
    slopes, after, at, zdot = np.zeros((STAGES, n)), np.zeros(n), np.zeros(n), np.zeros(n - CONTACT)
    h, shortest = FIRST_STEP * (end - t), SHORTEST_STEP * max(abs(t), abs(end))
    while t < end:
        step = min(h, end - t)
        if _field(rate, force, law, mass, drive, t, y, slopes[0]) != OK:
            return LAW_FAILED, t, filled
        error = _try_step(rate, force, law, mass, drive, t, step, y, slopes, scales, after)
        if error > 1.0:
            if step <= shortest:
                return STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE, t, filled
            h = step * _factor(error)
            continue
        later = t + step if step < end - t else end
        while filled < times.shape[0] and times[filled] < later:
            _between(y, slopes, step, (times[filled] - t) / step, at)
            _sample(rate, force, law, drive, times[filled], at, zdot, samples[filled])
            filled += 1
        y[:] = after
        if commit(y[CONTACT:], y[1], law) != OK:
            return LAW_FAILED, later, filled
        t, h = later, max(h if step < h else 0.0, step * _factor(error))
    return OK, t, filled


@kernel
def run_dynamic(
    rate: Rate,
    force: Force,
    commit: Commit,
    law: Vector,
    mass: float,
    y: Vector,
    scales: Vector,
    start: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
) -> tuple[int, float]:
    """Moves y = (x, v, q, z...), in place, from `start` [s] through segments that end at `ends` (s,) with `drives` (s, 10).

    scales (n,): the tolerance, the speed [m/s] that it is relative to, 0, and a size for each z; 0: z is not controlled. times (n,),
    ascending, within the run; samples (n, 5) are filled. Returns a status of engine/status.py and the time reached.
    """
    t, filled = start, 0
    for k in range(ends.shape[0]):
        status, t, filled = _segment(rate, force, commit, law, mass, y, scales, drives[k], t, ends[k], times, samples, filled)
        if status != OK:
            return status, t
    zdot = np.zeros(y.shape[0] - CONTACT)
    while filled < times.shape[0]:
        _sample(rate, force, law, drives[-1], times[filled], y, zdot, samples[filled])
        filled += 1
    return OK, t
