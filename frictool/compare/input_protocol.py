"""Inputs of the four tests of thesis 3.7, in the units of compare/comparison_setting.py.

stick-slip    a spring of 2 N/m pulled at 0.1 m/s for 60 s                             (3.7.2)
limit cycle   PID of 3 N/m, 6 N s/m, 4 N/(m s) towards 1 m for 300 s                   (3.40)
presliding    position at 1e-6 m/s between turning points, which are multiples of the
              largest presliding displacement z_max                                    (3.7.4)
drift         up to 1.6 N in 1 s, down to 0.5 N in 0.05 s, constant until 2 s, then
              0.5 + 0.4 sin(2 pi 2 (t - 2)) N until 102 s                              (3.7.5)

The thesis states no numbers for presliding and drift. All numbers above are for F_s = 1.5 F_c. For
another breakaway F_s, let fall = (F_s - F_c)/(0.5 F_c), with a lower limit (`UnitScales.fall`). The
spring is then pulled at 0.1 fall m/s, until 52.5 s after the first breakaway. If fall < 1, the
position loop lasts 300/fall s, because the integral part of the effort grows more slowly. The first
peak of the drift test is F_s + 0.1 N.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from frictool.compare.comparison_setting import UnitScales
from frictool.engine.drive import EffortFunction, held, pid, ramped, spring
from frictool.typing import Vector

# (end of the segment [s] from the start of the run, effort up to this end)
Segment = tuple[float, EffortFunction]

# PULL_TIME is measured from the first breakaway
SPRING_STIFFNESS, PULL_SPEED, PULL_TIME = 2.0, 0.1, 52.5
PROPORTIONAL, DERIVATIVE, INTEGRAL, TARGET, LOOP_TIME = 3.0, 6.0, 4.0, 1.0, 300.0
CREEP_SPEED = 1e-6
TURNING_POINTS = (0.0, 0.7, -0.7, 0.4, -0.2, 0.4, -0.7, 0.7, -0.7, 0.7, 1.2)  # in z_max
ABOVE_BREAKAWAY, BIAS, WAVE, FREQUENCY = 0.1, 0.5, 0.4, 2.0
RISE_END, FALL_END, WAVE_START, DRIFT_TIME = 1.0, 1.05, 2.0, 102.0


def stick_slip(scales: UnitScales) -> tuple[Segment, ...]:
    """Return the input of the stick-slip test: a spring, pulled at constant speed."""
    speed = PULL_SPEED * scales.fall
    first = scales.breakaway / (SPRING_STIFFNESS * speed)
    return (
        (
            (first + PULL_TIME) * scales.time,
            spring(SPRING_STIFFNESS * scales.force / scales.length, speed * scales.speed),
        ),
    )


def limit_cycle(scales: UnitScales) -> tuple[Segment, ...]:
    """Return the input of the limit-cycle test: a PID position loop (thesis (3.40))."""
    stiffness = scales.force / scales.length
    gains = (
        PROPORTIONAL * stiffness,
        DERIVATIVE * stiffness * scales.time,
        INTEGRAL * stiffness / scales.time,
    )
    return ((LOOP_TIME / min(1.0, scales.fall) * scales.time, pid(*gains, TARGET * scales.length)),)


def drift(scales: UnitScales) -> tuple[Segment, ...]:
    """Return the drift input: a peak above breakaway, then a wave below the Coulomb friction."""
    force = scales.force
    time = scales.time
    peak = scales.breakaway + ABOVE_BREAKAWAY
    omega = 2.0 * math.pi * FREQUENCY / time
    wave = EffortFunction(
        offset=BIAS * force,
        amplitude=WAVE * force,
        frequency=omega,
        phase=-omega * WAVE_START * time,
    )
    return (
        (RISE_END * time, ramped(0.0, peak * force / (RISE_END * time))),
        (
            FALL_END * time,
            ramped(
                peak * force,
                (BIAS - peak) * force / ((FALL_END - RISE_END) * time),
                RISE_END * time,
            ),
        ),
        (WAVE_START * time, held(BIAS * force)),
        (DRIFT_TIME * time, wave),
    )


def presliding_path(presliding: float, points: int) -> tuple[Vector, Vector]:
    """Return positions (10 * points + 1,) [m | rad], and the indices (11,) of the turning points.

    - presliding: largest presliding displacement z_max [m | rad]
    - points: number of steps between two turning points
    """
    legs = [np.linspace(a, b, points + 1)[1:] for a, b in pairwise(TURNING_POINTS)]
    path = np.concatenate([[TURNING_POINTS[0]], *legs]) * presliding
    return path, np.arange(len(TURNING_POINTS), dtype=np.float64) * points
