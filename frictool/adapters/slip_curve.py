"""Friction of a model as a function of speed, with its intervals, for each direction.

    F(v) = F_c + (F_s - F_c) exp(-(v/v_s)^delta) + viscous(v)         (thesis 2.33 and 2.34)

F_c is the Coulomb friction, F_s the breakaway, v_s the Stribeck velocity and delta an exponent.
viscous(v) is piecewise linear; a knee is a speed at which the slope of viscous(v) changes (figure
4.10 of the thesis).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.documents.laws import Laws
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.friction.position_polynomial import normalised_coefficients
from frictool.typing import Vector

# table of the friction over the position: largest error relative to the mean friction, largest
# number of points, and number of positions at which the error is computed
TABLE_ERROR, MOST_POSITIONS, FINE_POSITIONS = (0.01, 65, 1025)
STRIBECK_POINTS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)  # speeds in units of v_s

Level = Callable[[Quantity], float]  # the value of a quantity, or one end of its interval


class SlipCurve(NamedTuple):
    """Friction parameters of one direction with their intervals."""

    coulomb: Quantity
    breakaway: Quantity
    viscous: Quantity
    stribeck_velocity: Quantity | None
    exponent: float
    knees: tuple[Quantity, ...]
    slopes: tuple[Quantity, ...]

    def friction(self, speed: Vector) -> Vector:
        """Return the friction (n,) [N m | N] at speeds (n,) [rad/s | m/s] >= 0."""
        stribeck = None if self.stribeck_velocity is None else self.stribeck_velocity.value
        knees = [knee.value for knee in self.knees]
        return self._at(speed, lambda one: one.value, stribeck, knees)

    def band(self, speed: Vector) -> tuple[Vector, Vector]:
        """Return the least and largest friction (n,) [N m | N] within the intervals.

        The friction rises with the Coulomb friction, the breakaway and every slope. The low ends of
        these parameters therefore give the least friction, the high ends the largest. The Stribeck
        velocity and the knees are tried at both ends, because a larger value can raise or lower
        the friction.
        """
        velocity = self.stribeck_velocity
        velocities = (None,) if velocity is None else velocity.interval
        knees = list(itertools.product(*(knee.interval for knee in self.knees)))

        def curves(end: int) -> list[Vector]:
            return [
                self._at(speed, lambda one: one.interval[end], stribeck, list(corner))
                for stribeck, corner in itertools.product(velocities, knees)
            ]

        low, high = curves(0), curves(1)
        return np.min(low, axis=0), np.max(high, axis=0)

    def _at(
        self, speed: Vector, level: Level, stribeck: float | None, knees: list[float]
    ) -> Vector:
        bounds = [0.0, *knees, math.inf]
        force = np.full(speed.shape, level(self.coulomb))
        if stribeck is not None:
            fall = np.exp(-((speed / stribeck) ** self.exponent))
            force += (level(self.breakaway) - level(self.coulomb)) * fall
        for slope, (first, last) in zip(
            (self.viscous, *self.slopes), itertools.pairwise(bounds), strict=True
        ):
            force += level(slope) * (np.clip(speed, first, last) - first)
        return force


def slip_curve(model: Model, *, forward: bool) -> SlipCurve:
    """Return the friction parameters of the forward or the backward direction."""
    today, laws = model.parameters, model.laws or Laws()
    backward = None if forward else laws.backward
    slopes = (
        regime.viscous if forward or regime.backward is None else regime.backward
        for regime in laws.regimes
    )
    return SlipCurve(
        (backward and backward.coulomb) or today.coulomb,
        (backward and backward.breakaway) or today.breakaway,
        (backward and backward.viscous) or today.viscous,
        today.stribeck_velocity,
        laws.stribeck_exponent,
        tuple(regime.above for regime in laws.regimes),
        tuple(slopes),
    )


def bend_speeds(side: SlipCurve) -> list[float]:
    """Return the speeds at which the friction bends, in ascending order.

    These speeds are the knees and some multiples of v_s.
    """
    bends = [knee.value for knee in side.knees]
    if side.stribeck_velocity is not None:
        bends += [factor * side.stribeck_velocity.value for factor in STRIBECK_POINTS]
    return sorted(bends)


def is_plain(model: Model) -> bool:
    """Return True if the friction in slip consists of Coulomb and viscous friction only."""
    sides = [slip_curve(model, forward=one) for one in (True, False)]
    return sides[0] == sides[1] and not bend_speeds(sides[0])


def signed_friction(model: Model, smoothing: float) -> tuple[Vector, Vector]:
    """Return signed speeds (n,) [rad/s | m/s] and the friction (n,) [N m | N] that opposes them.

    The speeds are +-`smoothing`, those at which the friction bends, and the top speed in
    bench.yaml. Between -`smoothing` and +`smoothing` the friction is a straight line, because the
    sign of such a low speed is uncertain.
    """
    top = model.bench.mechanics.top_speed
    speeds, efforts = [], []
    for forward, sign in ((False, -1.0), (True, 1.0)):
        side = slip_curve(model, forward=forward)
        beyond = {speed for speed in bend_speeds(side) if speed > smoothing}
        last = max((2.0 * smoothing, *beyond, *((top.value,) if top is not None else ())))
        points = np.array(sorted({smoothing, last, *beyond}))
        friction = sign * side.friction(points)
        order = slice(None) if forward else slice(None, None, -1)
        speeds.append(sign * points[order])
        efforts.append(friction[order])
    return np.concatenate(speeds), np.concatenate(efforts)


def coulomb_change(model: Model) -> tuple[Vector, Vector, Vector]:
    """Return a table of the Coulomb friction over the position.

    Returns
    -------
    tuple of three arrays (n,)
        Rising positions [rad | m]; Coulomb friction minus its mean [N m | N] in the positive
        direction, and in the negative direction. Linear interpolation differs from the law by at
        most TABLE_ERROR times the mean Coulomb friction. The error may be larger for n >=
        MOST_POSITIONS. The arrays are empty if the friction does not depend on the position.
    """
    law = None if model.laws is None else model.laws.position
    if law is None:
        return np.empty(0), np.empty(0), np.empty(0)
    low, high = law.over.low, law.over.high

    def factors(powers: tuple[float, ...], positions: Vector) -> Vector:
        curve = normalised_coefficients(powers, low, high)
        return np.maximum(np.polynomial.polynomial.polyval(positions, curve), 0.0)

    sides = (law.coulomb.forward, law.coulomb.backward or law.coulomb.forward)
    fine = np.linspace(low, high, FINE_POSITIONS)
    count = 2
    while count < MOST_POSITIONS:
        points = np.linspace(low, high, count)
        errors = [
            np.interp(fine, points, factors(side, points)) - factors(side, fine) for side in sides
        ]
        if np.max(np.abs(errors)) <= TABLE_ERROR:
            break
        count = 2 * count - 1
    points = np.linspace(low, high, count)
    forward, backward = (
        slip_curve(model, forward=ahead).coulomb.value * (factors(side, points) - 1.0)
        for ahead, side in zip((True, False), sides, strict=True)
    )
    return points, forward, backward
