"""Conditions that change during a run: external efforts, parameter drifts, sensor faults.

The conditions are an array in SI units with one row per sample. Each value is constant until the
next sample.

====  ===============  =========================================================================
col.  name             meaning
====  ===============  =========================================================================
0     DISTURBANCE      external effort on the axis [N m | N]; positive values drive forward
1     FRICTION         factor of all dry friction: Coulomb, breakaway, their position maps, and
                       the friction inside the backlash
2     VISCOUS_FACTOR   factor of the viscous coefficients of all speed ranges
3     CONSTANT_FACTOR  factor of the drive's constant, in effort and back-electromotive force
4     LOST             counts lost by the encoder so far; the reading is too low by this number
5     ENCODER_FAULT    STUCK: the reading stays constant; INVALID: the reading is NaN; 0: no fault
6     SENSOR_OFFSET    offset a of the sensor of the drive [A | V]; 0 without fault
7     SENSOR_GAIN      gain b of the sensor of the drive; 1 without fault
====  ===============  =========================================================================

The sensor of the drive measures b drive + a. The inner loop of the drive makes the measured drive
equal to the command.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.engine.dynamic_law_axis import impose_on_law
from frictool.plant import axis as ax
from frictool.plant import axis_friction_laws as al
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

(
    DISTURBANCE,
    FRICTION,
    VISCOUS_FACTOR,
    CONSTANT_FACTOR,
    LOST,
    ENCODER_FAULT,
    SENSOR_OFFSET,
    SENSOR_GAIN,
) = range(8)
STUCK, INVALID = 1.0, 2.0  # values of ENCODER_FAULT
CONDITIONS_SIZE = 8
NEUTRAL = (0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0)  # row without any effect
NO_CONDITIONS: Vector = np.empty((0, CONDITIONS_SIZE))


def neutral(samples: int) -> Vector:
    """Return conditions (samples, 8) that have no effect."""
    return constant(np.array(NEUTRAL), samples)


@kernel
def constant(row: Vector, samples: int) -> Vector:
    """Return conditions (samples, 8) in which every row equals `row` (8,)."""
    rows = np.empty((samples, CONDITIONS_SIZE))
    for k in range(samples):
        for column in range(CONDITIONS_SIZE):
            rows[k, column] = row[column]
    return rows


@kernel
def extremes(values: Vector) -> tuple[float, float]:
    """Return the smallest and the largest of the values (n,); all values must be finite, n >= 1."""
    low = high = values[0]
    for value in values:
        low = min(low, value)
        high = max(high, value)
    return low, high


@kernel
def impose(axis: Vector, p: Vector, row: Vector) -> None:
    """Write the parameters `axis` (plant/axis.py), changed by the conditions `row` (8,), to `p`."""
    friction, viscous = row[FRICTION], row[VISCOUS_FACTOR]
    p[ax.COULOMB], p[ax.BREAKAWAY] = friction * axis[ax.COULOMB], friction * axis[ax.BREAKAWAY]
    p[ax.BACKLASH_COULOMB] = friction * axis[ax.BACKLASH_COULOMB]
    p[ax.BACKLASH_BREAKAWAY] = friction * axis[ax.BACKLASH_BREAKAWAY]
    p[ax.VISCOUS] = viscous * axis[ax.VISCOUS]
    p[ax.CONSTANT] = row[CONSTANT_FACTOR] * axis[ax.CONSTANT]
    p[ax.OFFSET] = axis[ax.OFFSET] - row[DISTURBANCE]
    p[ax.DRIVE_LIMIT] = math.inf  # `true_command` has already limited the command
    if axis.shape[0] > al.PLAIN_SIZE:
        for side in range(2):
            p[al.VISCOUS_PAIR + side] = viscous * axis[al.VISCOUS_PAIR + side]
            p[al.COULOMB_PAIR + side] = friction * axis[al.COULOMB_PAIR + side]
            p[al.BREAKAWAY_PAIR + side] = friction * axis[al.BREAKAWAY_PAIR + side]
        for regime in range(al.REGIMES, al.COULOMB_MAPS, al.REGIME_SIZE):
            p[regime + 1], p[regime + 2] = viscous * axis[regime + 1], viscous * axis[regime + 2]
        for term in range(al.COULOMB_MAPS, al.DYNAMIC_SIZE):
            p[term] = friction * axis[term]
        impose_on_law(axis, p, friction, viscous)


def with_friction(axis: Vector, viscous: float, dry: float) -> Vector:
    """Return the parameters `axis` with friction multiplied by the factors `viscous` and `dry`.

    The drive of the axis must have no limit.
    """
    row = neutral(1)[0]
    row[VISCOUS_FACTOR], row[FRICTION] = viscous, dry
    p = axis.copy()
    impose(axis, p, row)
    return p


@kernel
def changes_parameters(before: Vector, row: Vector) -> bool:
    """Return True if the conditions `before` and `row` (8,) lead to different axis parameters."""
    return bool(
        row[DISTURBANCE] != before[DISTURBANCE]
        or row[FRICTION] != before[FRICTION]
        or row[VISCOUS_FACTOR] != before[VISCOUS_FACTOR]
        or row[CONSTANT_FACTOR] != before[CONSTANT_FACTOR]
    )


@kernel
def true_command(command: float, limit: float, row: Vector) -> float:
    """Return the drive [A | V] that results from a command if the drive's sensor has a fault.

    The command is limited first. A command that is not finite is returned unchanged.
    """
    if not math.isfinite(command):
        return command
    return float((min(max(command, -limit), limit) - row[SENSOR_OFFSET]) / row[SENSOR_GAIN])


@kernel
def faulty(reported: float, step: float, last: float, row: Vector) -> float:
    """Return the reading [rad | m] of an encoder with the faults in the conditions `row` (8,).

    - reported: reading without faults
    - last: reading at the previous sample
    - step: resolution [rad | m]
    """
    if row[ENCODER_FAULT] == INVALID:
        return math.nan
    return float(last if row[ENCODER_FAULT] == STUCK else reported - row[LOST] * step)
