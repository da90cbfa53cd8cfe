"""What happens to a loop while it runs: loads from outside, parameters that drift, sensors that
fail. One row a sample, in SI.

====  ================
===========================================================================================================
col.  name              meaning over the sample that begins
====  ================
===========================================================================================================
0     DISTURBANCE       effort on the axis beside the drive's [N m | N], positive drives forward
1     FRICTION          factor on all dry friction: Coulomb, breakaway, their maps over position,
      those inside the backlash
2     VISCOUS_FACTOR    factor on the viscous coefficients of every regime; knees stay
3     CONSTANT_FACTOR   factor on the drive's constant, effort and back-electromotive force alike
4     LOST              counts that the encoder has lost so far: it reports so many too few
5     ENCODER_FAULT     STUCK: the encoder goes on reporting what it reported last; INVALID: what it
      reports is no number (NaN); else 0
6     SENSOR_OFFSET     a, b in (measured drive) = b (drive) + a, where the drive's own loop makes
      the measured one follow its
7     SENSOR_GAIN       command; 0 and 1 without a fault
====  ================
===========================================================================================================

Under constant factors an axis is the one whose parameters are so many times as large from the
start.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.plant.axis import (
    BACKLASH_BREAKAWAY,
    BACKLASH_COULOMB,
    BREAKAWAY,
    CONSTANT,
    COULOMB,
    DRIVE_LIMIT,
    OFFSET,
    VISCOUS,
)
from frictool.plant.axis_friction_laws import (
    BREAKAWAY_PAIR,
    COULOMB_MAPS,
    COULOMB_PAIR,
    EXTENDED_SIZE,
    PLAIN_SIZE,
    REGIME_SIZE,
    REGIMES,
    VISCOUS_PAIR,
)
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]

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
STUCK, INVALID = 1.0, 2.0  # of ENCODER_FAULT
CONDITIONS_SIZE = 8
NEUTRAL = (0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0)  # a row in which nothing happens
NO_CONDITIONS: Vector = np.empty((0, CONDITIONS_SIZE))


def neutral(samples: int) -> Vector:
    """Conditions (samples, 8) under which nothing happens."""
    return np.tile(np.array(NEUTRAL), (samples, 1))


@kernel
def impose(axis: Vector, p: Vector, row: Vector) -> None:
    """Fills the parameters `p` with those of `axis` (plant/axis.py, same length) under the
    conditions `row` (8,)."""
    friction, viscous = row[FRICTION], row[VISCOUS_FACTOR]
    p[COULOMB], p[BREAKAWAY] = friction * axis[COULOMB], friction * axis[BREAKAWAY]
    p[BACKLASH_COULOMB], p[BACKLASH_BREAKAWAY] = (
        friction * axis[BACKLASH_COULOMB],
        friction * axis[BACKLASH_BREAKAWAY],
    )
    p[VISCOUS], p[CONSTANT] = viscous * axis[VISCOUS], row[CONSTANT_FACTOR] * axis[CONSTANT]
    p[OFFSET] = axis[OFFSET] - row[DISTURBANCE]
    p[DRIVE_LIMIT] = math.inf  # `true_command` has limited what the drive's loop is asked for
    if axis.shape[0] > PLAIN_SIZE:
        for side in range(2):
            p[VISCOUS_PAIR + side] = viscous * axis[VISCOUS_PAIR + side]
            p[COULOMB_PAIR + side] = friction * axis[COULOMB_PAIR + side]
            p[BREAKAWAY_PAIR + side] = friction * axis[BREAKAWAY_PAIR + side]
        for regime in range(REGIMES, COULOMB_MAPS, REGIME_SIZE):
            p[regime + 1], p[regime + 2] = viscous * axis[regime + 1], viscous * axis[regime + 2]
        for term in range(COULOMB_MAPS, EXTENDED_SIZE):
            p[term] = friction * axis[term]


@kernel
def true_command(command: float, limit: float, row: Vector) -> float:
    """The drive [A | V] at which the sensor of the drive's loop shows the limited command; a
    command that is no number stays one."""
    if not math.isfinite(command):
        return command
    return float((min(max(command, -limit), limit) - row[SENSOR_OFFSET]) / row[SENSOR_GAIN])


@kernel
def faulty(reported: float, step: float, last: float, row: Vector) -> float:
    """What the encoder shows [rad | m] where a sound one has `reported`; `last`: what it showed at
    the sample before."""
    if row[ENCODER_FAULT] == INVALID:
        return math.nan
    return float(last if row[ENCODER_FAULT] == STUCK else reported - row[LOST] * step)
