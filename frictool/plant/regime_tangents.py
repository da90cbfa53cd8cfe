"""Friction whose slope changes with speed, as a scheduled parameter, annex (30)-(32).

    |F(v)| = F_c + s_0 |v| below the first knee; above knee k the slope is s_k, F is continuous
    regime k has the tangent F_c(k) + s_k |v|
    F_c(k) = F_c - sum over the knees i <= k of (s_i - s_(i-1)) v_i

Figure 4.10 shows such a curve. With one knee and s_0 = 0 this is (31): F_c(rho) = F_c - s v_lim
rho, s(rho) = s rho, rho in {0, 1}; the polytope contains every rho between. F_c(k) may be negative:
it only keeps F continuous and is not a friction by itself (5.4.2).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

Ends = tuple[float, float]


@dataclass(frozen=True)
class RegimeTangent:
    """viscous [N m s/rad or N s/m] and coulomb [N m or N] of the tangent of one regime."""

    viscous: float
    coulomb: float


@dataclass(frozen=True)
class RegimeLevels:
    """Intervals (low, high) of F_c and of the slope of each regime.

    above: speed at which each regime begins [rad/s or m/s], 0 for the first.
    """

    coulomb: Ends
    above: tuple[float, ...]
    viscous: tuple[Ends, ...]

    def tangent(self, level: int, coulomb: float, slopes: tuple[float, ...]) -> RegimeTangent:
        """Return the tangent of regime `level` for one F_c and one slope per regime."""
        lost = sum((slopes[i] - slopes[i - 1]) * self.above[i] for i in range(1, level + 1))
        return RegimeTangent(slopes[level], coulomb - lost)


def tangents(levels: RegimeLevels, *, viscous: bool, coulomb: bool) -> tuple[RegimeTangent, ...]:
    """Return the tangents at the corners: every regime, with both ends of scheduled parameters.

    viscous, coulomb: True if the slopes (all low or all high) or F_c are scheduled too. A parameter
    that is not scheduled has its upper end. The polytope between the regimes then contains the
    lower values. The annex covers the uncertainty of both parameters in this way ("bounded by the
    variations of F_c(rho) and sigma_v(rho)", after (32)).
    """
    lows, highs = zip(*levels.viscous, strict=True)
    slopes = (lows, highs) if viscous else (highs,)
    forces = levels.coulomb if coulomb else levels.coulomb[1:]
    corners = [
        levels.tangent(level, force, chosen)
        for chosen, force, level in itertools.product(slopes, forces, range(len(levels.above)))
    ]
    return tuple(dict.fromkeys(corners))
