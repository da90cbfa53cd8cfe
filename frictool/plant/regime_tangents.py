"""Friction that changes its slope with speed as a scheduled parameter, annex (30)-(32).

    |F(v)| = F_c + s_0 |v| below the first knee; beyond knee k the slope is s_k, and F is continuous
    there (figure 4.10).
    regime k is its tangent F_c(k) + s_k |v|:     s_k,     F_c(k) = F_c - sum over the knees i <= k
                                                  of (s_i - s_(i-1)) v_i

With one knee and s_0 = 0 that is (31): F_c(rho) = F_c - s v_lim rho, s(rho) = s rho, rho in {0, 1};
the polytope holds every rho between. F_c(k) may be negative: it then keeps F continuous and is no
friction of its own (5.4.2).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.errors import FrictoolError

Ends = tuple[float, float]


@dataclass(frozen=True)
class RegimeTangent:
    """viscous [N m s/rad or N s/m] and coulomb [N m or N] of one regime."""

    viscous: float
    coulomb: float


@dataclass(frozen=True)
class RegimeLevels:
    """(low, high) of F_c; for each regime the speed where it begins [rad/s or m/s] (the first: 0)
    and (low, high) of its slope."""

    coulomb: Ends
    above: tuple[float, ...]
    viscous: tuple[Ends, ...]

    def tangent(self, level: int, coulomb: float, slopes: tuple[float, ...]) -> RegimeTangent:
        """Of regime `level` for one F_c and one slope for each regime."""
        lost = sum((slopes[i] - slopes[i - 1]) * self.above[i] for i in range(1, level + 1))
        return RegimeTangent(slopes[level], coulomb - lost)


def regime_levels(model: Model, coulomb: Ends) -> RegimeLevels:
    """The model's regimes in both directions; `coulomb`: the interval of F_c at low speed.

    The bench's range of the viscous coefficient is that of the steepest regime, so that the slope
    below the first knee is the model's own. Raises FrictoolError where the model has no regimes.
    """
    if model.laws is None or not model.laws.regimes:
        raise FrictoolError(
            "regime: found a model without laws.regimes; allowed: to schedule regimes that the model has; "
            "schedule viscous and coulomb instead, or identify from a log that goes beyond the knee"
        ).at("design", "schedule")
    own = model.laws.backward
    slow = (model.parameters.viscous, *((own.viscous,) if own and own.viscous else ()))
    fast = [
        (regime.viscous, *((regime.backward,) if regime.backward else ()))
        for regime in model.laws.regimes
    ]
    return RegimeLevels(
        coulomb,
        (0.0, *(regime.above.value for regime in model.laws.regimes)),
        tuple(map(_hull, (slow, *fast))),
    )


def _hull(found: tuple[Quantity, ...]) -> Ends:
    return min(one.interval[0] for one in found), max(one.interval[1] for one in found)


def tangents(levels: RegimeLevels, *, viscous: bool, coulomb: bool) -> tuple[RegimeTangent, ...]:
    """The tangents at the corners: every regime, with both ends of F_c and of the slopes (all low,
    all high) where those are scheduled too.

    Where they are not, the upper ends: between its regimes the polytope then holds what is below,
    which is how the annex covers the uncertainty of both ("bounded by the variations of F_c(rho)
    and sigma_v(rho)", after (32)).
    """
    lows, highs = zip(*levels.viscous, strict=True)
    slopes = (lows, highs) if viscous else (highs,)
    forces = levels.coulomb if coulomb else levels.coulomb[1:]
    corners = [
        levels.tangent(level, force, chosen)
        for chosen, force, level in itertools.product(slopes, forces, range(len(levels.above)))
    ]
    return tuple(dict.fromkeys(corners))
