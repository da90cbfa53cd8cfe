"""The motion under Coulomb and viscous friction of fixed sign, and the effort at rest: power series to rounding.

    m v' = u(t, x, v, q) - friction - viscous v        x' = v        q' = x - r        (engine/drive.py)

is linear with constant coefficients: its solution is the matrix exponential, and the matrix exponential is its power series. Each
coefficient follows from the one before; a piece is as long as the series is exact to rounding, and needs no step size.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.engine.drive import (
    AMPLITUDE,
    DERIVATIVE,
    FREQUENCY,
    INTEGRAL,
    OFFSET,
    PHASE,
    PROPORTIONAL,
    SLOPE,
    TARGET,
    TARGET_SPEED,
)
from frictool.kernels import kernel

Vector = NDArray[np.float64]

TERMS = 24
EXACT = 2.0**-54  # of the size of the quantity: what the last terms may be
REFINEMENTS = 3  # the size depends on the length weakly: to the power 1/TERMS


@kernel
def motion(
    y: Vector, t: float, drive: Vector, mass: float, friction: float, viscous: float, moving: bool, start: float, piece: Vector
) -> None:
    """Fills `piece` (4, TERMS), rows x, v, q, u, with the series of the time since t, from y = (x, v, q).

    `friction`, `viscous`: friction + viscous v opposes the motion. At rest (not `moving`) x and v stay. `start`: the acceleration at t,
    given because rounding is taken out of it where slip begins.
    """
    cycle = drive[FREQUENCY] * t + drive[PHASE]
    swing, other = drive[AMPLITUDE] * math.sin(cycle), drive[AMPLITUDE] * math.cos(cycle)
    piece[0, 0], piece[1, 0], piece[2, 0] = y[0], y[1], y[2]
    for k in range(TERMS):
        error = piece[0, k]
        u = swing
        if k == 0:
            error -= drive[TARGET] + drive[TARGET_SPEED] * t
            u += drive[OFFSET] + drive[SLOPE] * t
        elif k == 1:
            error -= drive[TARGET_SPEED]
            u += drive[SLOPE]
        u -= drive[PROPORTIONAL] * error + drive[DERIVATIVE] * piece[1, k] + drive[INTEGRAL] * piece[2, k]
        piece[3, k] = u
        if k + 1 < TERMS:
            net = u - viscous * piece[1, k] - (friction if k == 0 else 0.0)
            piece[0, k + 1] = piece[1, k] / (k + 1) if moving else 0.0
            piece[1, k + 1] = (start if k == 0 else net / (mass * (k + 1))) if moving else 0.0
            piece[2, k + 1] = error / (k + 1)
        swing, other = drive[FREQUENCY] * other / (k + 1), -drive[FREQUENCY] * swing / (k + 1)


@kernel
def reach(c: Vector) -> float:
    """For how long the series c (TERMS,) is exact to rounding; inf for a polynomial.

    The last two terms stay below EXACT of the largest of the first half: so near, no term is so large that the sum loses digits.
    """
    longest = math.inf
    for k in (TERMS - 2, TERMS - 1):
        if c[k] == 0.0:
            continue
        h = 1.0
        for _ in range(REFINEMENTS):
            largest, power = 0.0, 1.0
            for j in range(TERMS // 2):
                largest = max(largest, abs(c[j]) * power)
                power *= h
            h = math.exp((math.log(EXACT) + math.log(largest) - math.log(abs(c[k]))) / k)
        longest = min(longest, h)
    return longest
