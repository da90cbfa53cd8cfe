"""Friction with a different viscous coefficient in each speed range, as a scheduled parameter.

A speed range is called a regime; a knee is the speed between two regimes. The friction of annex C
of the thesis, (30)-(32), is piecewise linear and continuous in |v|, and equals the Coulomb friction
F_c at v = 0. The slope is s_0 below the first knee v_1 and s_k above knee k, as in figure 4.10 of
the thesis. Regime k has the tangent

    F_c(k) + s_k |v|      with F_c(k) = F_c - sum over the knees i <= k of (s_i - s_(i-1)) v_i

With one knee at the speed v_lim, s_0 = 0 and s_1 = s, this is annex (31): F_c(rho) = F_c - s v_lim
rho, s(rho) = s rho, rho in {0, 1}. The polytope contains every rho in [0, 1]. F_c(k) may be
negative, because it is the intercept of a tangent and not a friction (5.4.2).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

Ends = tuple[float, float]


@dataclass(frozen=True)
class RegimeTangent:
    """Slope [N m s/rad or N s/m] and intercept [N m or N] of the tangent in one speed range."""

    viscous: float
    coulomb: float


@dataclass(frozen=True)
class RegimeLevels:
    """Intervals (low, high) of the Coulomb friction, and of the viscous slope in each speed range.

    above: speed at which each range (regime) begins [rad/s or m/s], 0 for the first.
    """

    coulomb: Ends
    above: tuple[float, ...]
    viscous: tuple[Ends, ...]

    def tangent(self, level: int, coulomb: float, slopes: tuple[float, ...]) -> RegimeTangent:
        """Return the tangent of the regime with the index `level`.

        slopes: viscous coefficient of each regime.
        """
        lost = sum((slopes[i] - slopes[i - 1]) * self.above[i] for i in range(1, level + 1))
        return RegimeTangent(slopes[level], coulomb - lost)


def tangents(levels: RegimeLevels, *, viscous: bool, coulomb: bool) -> tuple[RegimeTangent, ...]:
    """Return the tangents of every regime (speed range), at both ends of the scheduled intervals.

    - viscous: True if the slopes are scheduled
    - coulomb: True if the Coulomb friction is scheduled

    Either all slopes are at the lower ends of their intervals, or all are at the upper ends. A
    parameter that is not scheduled has the upper end of its interval; the polytope also contains
    the plants with lower values, as the annex states after (32).
    """
    lows, highs = zip(*levels.viscous, strict=True)
    slopes = (lows, highs) if viscous else (highs,)
    forces = levels.coulomb if coulomb else levels.coulomb[1:]
    corners = [
        levels.tangent(level, force, chosen)
        for chosen, force, level in itertools.product(slopes, forces, range(len(levels.above)))
    ]
    return tuple(dict.fromkeys(corners))
