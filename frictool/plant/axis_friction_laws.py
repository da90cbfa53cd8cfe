"""Friction of an axis that depends on direction, speed, position and time at rest, and end stops.

    slipping   friction = (F_c + (F_s - F_c) exp(-|v/v_s|^delta)) sign(v) + viscous v
               (2.33)-(2.34); above a knee speed the viscous coefficient changes
    at rest    v = 0 as long as |e| <= F_s (1 - (1 - fresh) tau/(tau + t)), never below F_c
               (friction/rising_breakaway.py)
    position   F_c and F_s of each direction are polynomials of the motor's position
               (4.41)-(4.44)
    end stops  the motor stays in [low, high]; it rebounds at `restitution` times its speed

F_c is the Coulomb friction, F_s the breakaway, v the speed, e the effort, and t the time at rest.
v_s, delta, fresh and tau are parameters. Friction is continuous at a knee speed (thesis, figure
4.10). The numbers in brackets are equations of the thesis. While the backlash is open, the end
stops act, but this friction does not. F_s of the Stribeck curve is the breakaway at the end of the
last rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.friction.polynomial_minimum import minimum
from frictool.friction.position_polynomial import least_factor, normalised_coefficients
from frictool.friction.stribeck import straight_from
from frictool.typing import Vector

Coefficients = tuple[float, ...]  # lowest power first
Sides = tuple[Coefficients, Coefficients]  # forward, backward

PLAIN_SIZE = 14  # number of parameters of an axis without these laws
MAX_REGIMES, MAX_TERMS = 4, 8

# indices after the plain parameters; the index of a pair's element is base + (direction > 0):
# backward, then forward
VISCOUS_PAIR, COULOMB_PAIR, BREAKAWAY_PAIR, STOP_PAIR = range(PLAIN_SIZE, PLAIN_SIZE + 8, 2)
RESTITUTION, STRIBECK_VELOCITY, STRIBECK_EXPONENT, LAYER, FRESH, RISE_TIME = range(
    PLAIN_SIZE + 8, PLAIN_SIZE + 14
)
# each regime has three elements: knee, viscous backward, viscous forward
MAPPED, MAP_LOW, MAP_HIGH, REGIMES = range(PLAIN_SIZE + 14, PLAIN_SIZE + 18)
COULOMB_MAPS = REGIMES + 3 * MAX_REGIMES
BREAKAWAY_MAPS = COULOMB_MAPS + 2 * MAX_TERMS
# number of elements of a dynamic law, which follow (engine/dynamic_law_axis.py); 0: none
DYNAMIC_SIZE = BREAKAWAY_MAPS + 2 * MAX_TERMS
EXTENDED_SIZE = DYNAMIC_SIZE + 1

REGIME_SIZE = 3
ROUNDING = 1e-12


class ViscousRegime(NamedTuple):
    """Viscous coefficients [N m s/rad | N s/m] of each direction above `knee` [rad/s | m/s]."""

    knee: float
    forward: float
    backward: float


class AxisFrictionLevels(NamedTuple):
    """Friction in one direction: viscous [N m s/rad | N s/m], coulomb and breakaway [N m | N]."""

    viscous: float
    coulomb: float
    breakaway: float


class FrictionPositionShape(NamedTuple):
    """Coulomb friction and breakaway as functions of the position, from low to high [rad | m].

    - coulomb, breakaway: pairs (forward, backward) of polynomial coefficients, in any effort unit

    Each polynomial, divided by its mean, multiplies the friction level of its direction. Outside
    the range `low` to `high`, friction is constant.
    """

    low: float
    high: float
    coulomb: Sides
    breakaway: Sides


class AxisLaws(NamedTuple):
    """Friction of an axis by direction, speed, position and time at rest, and end stops; SI.

    With the default values, only the friction in `AxisParameters` acts.

    - backward: friction in the negative direction; None if it equals the friction in the positive
      direction
    - fresh: breakaway just after a stop divided by the breakaway after a long rest
    - rise_time: rise time tau of the breakaway, s; 0 if the breakaway does not depend on the time
      at rest
    - stribeck_velocity: 0 without Stribeck effect
    """

    backward: AxisFrictionLevels | None = None
    regimes: tuple[ViscousRegime, ...] = ()
    stribeck_velocity: float = 0.0  # rad/s | m/s
    stribeck_exponent: float = 2.0
    fresh: float = 1.0
    rise_time: float = 0.0  # s
    shape: FrictionPositionShape | None = None
    stops: tuple[float, float] = (-math.inf, math.inf)  # rad | m
    restitution: float = 0.0

    def pack(self, forward: AxisFrictionLevels) -> Vector:
        """Return the values of the laws, which follow `AxisParameters` in the array for kernels.

        forward: friction in the positive direction. The array is empty if the laws change nothing.
        Raises ValueError with the name of a value that is out of range.
        """
        if self == AxisLaws():
            return np.empty(0)
        sides = (self.backward or forward, forward)
        sides = (_lifted(sides[0]), _lifted(sides[1]))
        self._check(sides)
        out = np.zeros(EXTENDED_SIZE)
        for base, values in (
            (VISCOUS_PAIR, "viscous"),
            (COULOMB_PAIR, "coulomb"),
            (BREAKAWAY_PAIR, "breakaway"),
        ):
            out[base], out[base + 1] = (getattr(side, values) for side in sides)
        out[STOP_PAIR], out[STOP_PAIR + 1], out[RESTITUTION] = *self.stops, self.restitution
        out[STRIBECK_VELOCITY] = self.stribeck_velocity
        out[STRIBECK_EXPONENT] = self.stribeck_exponent
        out[LAYER] = straight_from(self.stribeck_velocity, self.stribeck_exponent)
        out[FRESH], out[RISE_TIME] = self.fresh, self.rise_time
        out[REGIMES:COULOMB_MAPS:REGIME_SIZE] = math.inf
        for index, regime in enumerate(self.regimes):
            out[REGIMES + REGIME_SIZE * index :][:REGIME_SIZE] = (
                regime.knee,
                regime.backward,
                regime.forward,
            )
        if self.shape is not None:
            out[MAPPED] = 1.0
            out[MAP_LOW] = self.shape.low
            out[MAP_HIGH] = self.shape.high
            out[COULOMB_MAPS:DYNAMIC_SIZE] = _maps(self.shape, sides)
        return out[PLAIN_SIZE:]

    def _check(self, sides: tuple[AxisFrictionLevels, AxisFrictionLevels]) -> None:
        for side in sides:
            for name, value in side._asdict().items():
                _within(f"backward {name}", value, 0.0, math.inf)
        if len(self.regimes) > MAX_REGIMES:
            raise ValueError(f"regimes: found {len(self.regimes)}; allowed: at most {MAX_REGIMES}")
        last = 0.0
        for regime in self.regimes:
            if not last < regime.knee < math.inf:
                raise ValueError(
                    f"regimes: a knee at {regime.knee:g}; allowed: knees above 0 in rising order"
                )
            for value in regime[1:]:
                _within(f"viscous beyond the knee at {regime.knee:g}", value, 0.0, math.inf)
            last = regime.knee
        _within("stribeck_velocity", self.stribeck_velocity, 0.0, math.inf)
        _within("stribeck_exponent", self.stribeck_exponent, 0.5, 4.5)
        _within("rise_time", self.rise_time, 0.0, math.inf)
        _within("restitution", self.restitution, 0.0, 1.0)
        if not 0.0 < self.fresh <= 1.0:
            raise ValueError(f"fresh is {self.fresh:g}; allowed: > 0 and <= 1")
        if not self.stops[0] < self.stops[1]:
            raise ValueError(
                f"end stops at {self.stops[0]:g} and {self.stops[1]:g}; allowed: low < high"
            )


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value < high:
        raise ValueError(f"{name} is {value:g}; allowed: >= {low:g} and < {high:g}")


def _lifted(side: AxisFrictionLevels) -> AxisFrictionLevels:
    return side._replace(breakaway=max(side.coulomb, side.breakaway))


def _maps(
    shape: FrictionPositionShape, sides: tuple[AxisFrictionLevels, AxisFrictionLevels]
) -> Vector:
    """Return the coefficients (4, MAX_TERMS) of the friction's polynomials, in N m | N.

    The rows are F_c backward, F_c forward, F_s backward and F_s forward. Raises ValueError if
    0 <= F_c <= F_s does not hold.
    """
    out, over = np.zeros((4, MAX_TERMS)), (shape.low, shape.high)
    for index, level in enumerate(sides):
        slip, rest = shape.coulomb[1 - index], shape.breakaway[1 - index]
        for row, terms, value in ((index, slip, level.coulomb), (2 + index, rest, level.breakaway)):
            if len(terms) > MAX_TERMS:
                raise ValueError(
                    f"a polynomial of position has {len(terms)} coefficients; allowed: at "
                    f"most {MAX_TERMS}"
                )
            out[row, : len(terms)] = [value * one for one in normalised_coefficients(terms, *over)]
        position, part = least_factor(slip, *over)
        excess = (
            (position, (level.breakaway - level.coulomb) * part)
            if rest == slip
            else minimum(out[2 + index] - out[index], *over)
        )
        tolerance = ROUNDING * (level.breakaway + level.coulomb)
        for name, (where, smallest) in (
            ("Coulomb friction", (position, level.coulomb * part)),
            ("breakaway minus Coulomb friction", excess),
        ):
            if smallest < -tolerance:
                negative = (
                    f"{name} {('backward', 'forward')[index]} is {smallest:.3g} at {where:.4g}"
                )
                raise ValueError(f"position: {negative}; allowed: >= 0 in the polynomials' range")
    return out.ravel()
