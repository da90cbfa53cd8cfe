"""Power series of the motion under friction of fixed sign and at rest, exact to rounding.

    m v' = u(t, x, v, q) - friction - viscous v        x' = v        q' = x - r

x is the position, v the velocity, r the reference, and q the integral of x - r. engine/drive.py
defines the effort u. A series is used up to the time at which it loses accuracy (`reach`); there is
no step-size control.
"""

from __future__ import annotations

import math

from frictool.engine import drive as dr
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

TERMS = 24
EXACT = 2.0**-54  # largest magnitude of the last terms, relative to the size of the quantity
REFINEMENTS = 3  # iterations of `reach`; few suffice, since it depends weakly on the largest term


@kernel
def motion(
    y: Vector,
    t: float,
    drive: Vector,
    mass: float,
    viscous: float,
    moving: bool,
    start: float,
    piece: Vector,
) -> None:
    """Fill the rows x, v, q and u of `piece` (4, TERMS) with power series in the time since t.

    - y: (x, v, q) at t. If `moving` is False, x and v are constant
    - start: acceleration at t, including friction. At the beginning of a slip, an acceleration that
      is 0 to rounding must be passed as 0
    """
    frequency = drive[dr.FREQUENCY]
    proportional = drive[dr.PROPORTIONAL]
    derivative = drive[dr.DERIVATIVE]
    integral = drive[dr.INTEGRAL]
    cycle = frequency * t + drive[dr.PHASE]
    mobility = 1.0 / mass
    swing, other = 0.0, 0.0
    if drive[dr.AMPLITUDE] != 0.0:
        swing, other = drive[dr.AMPLITUDE] * math.sin(cycle), drive[dr.AMPLITUDE] * math.cos(cycle)
    x, v, q = y[0], y[1], y[2]
    for k in range(TERMS):
        share = 1.0 / (k + 1)
        error = x
        u = swing
        if k == 0:
            error -= drive[dr.TARGET] + drive[dr.TARGET_SPEED] * t
            u += drive[dr.OFFSET] + drive[dr.SLOPE] * t
        elif k == 1:
            error -= drive[dr.TARGET_SPEED]
            u += drive[dr.SLOPE]
        u -= proportional * error + derivative * v + integral * q
        piece[0, k] = x
        piece[1, k] = v
        piece[2, k] = q
        piece[3, k] = u
        net = (u - viscous * v) * mobility if k > 0 else start
        x = v * share if moving else 0.0
        v = net * share if moving else 0.0
        q = error * share
        swing, other = frequency * other * share, -frequency * swing * share


@kernel
def reach(c: Vector) -> float:
    """Return the time [s] up to which the series c (TERMS,) is exact to rounding.

    Up to this time, the last two terms are below EXACT times the largest term of the first half of
    the series. For a polynomial of lower degree, the time is infinite.
    """
    longest = math.inf
    for k in (TERMS - 2, TERMS - 1):
        if c[k] == 0.0:
            continue
        h = 1.0
        smallest = math.log(EXACT) - math.log(abs(c[k]))
        for _ in range(REFINEMENTS):
            largest, power = 0.0, 1.0
            for j in range(TERMS // 2):
                largest = max(largest, abs(c[j]) * power)
                power *= h
            h = math.exp((smallest + math.log(largest)) / k)
        longest = min(longest, h)
    return longest
