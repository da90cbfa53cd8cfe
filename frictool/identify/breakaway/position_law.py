"""Friction over position, per direction (4.44): polynomials whose order the data choose, and
whether the directions differ at all.

    |friction| = sum_k c_k P_k(xi)         xi = the position in [-1, 1], P_k Legendre's: c_0 is the
                                           mean over the range

Orders: the smallest whose error on breakaways left out is within two standard errors of the best's,
compared breakaway by breakaway: a needless order is taken in one log of twenty and not in three
(one standard error, Breiman et al. 1984). The same rule decides between a polynomial for each
direction and a common one with an offset of the effort.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from numpy.polynomial.legendre import legvander

from frictool.identify.motion_record import Vector
from frictool.identify.regression.regression import LeastSquaresSolution, Matrix, solve

HIGHEST_ORDER = 6
FOLLOWING, FEWEST_GROUPS = 4, 12  # breakaways that count as one, where there are enough of them
SURE = 2.0  # standard errors
ROWS_PER_TERM = 6  # breakaways that each coefficient needs


@dataclass(frozen=True)
class PolynomialOrders:
    """`orders` (forward, backward), -1 where a direction has no data; `common`: one polynomial, of
    the first order, and an offset."""

    orders: tuple[int, int]
    common: bool

    @property
    def constant(self) -> bool:
        """Whether position and direction tell nothing."""
        return max(self.orders) == 0 and (self.common or min(self.orders) < 0)


@dataclass(frozen=True)
class BreakawayPositions:
    """Where n breakaways were: `position` (n,) rad | m, `direction` (n,) +-1, and the range [low,
    high] that they span."""

    position: Vector
    direction: Vector
    low: float
    high: float

    @property
    def scaled(self) -> Vector:
        """xi (n,)."""
        return (
            2.0 * (self.position - self.low) / (self.high - self.low) - 1.0
            if self.high > self.low
            else 0.0 * self.position
        )

    def design(self, structure: PolynomialOrders) -> Matrix:
        """Regressors (n, p): forward, then backward; of a common structure the polynomial, then the
        sign for the offset."""
        if structure.common:
            return np.column_stack((legvander(self.scaled, structure.orders[0]), self.direction))
        sides = []
        for side, order in zip((1.0, -1.0), structure.orders, strict=True):
            if order >= 0:
                sides.append(legvander(self.scaled, order) * (self.direction == side)[:, None])
        return np.column_stack(sides)

    def powers(self, coefficients: Vector) -> tuple[float, ...]:
        """Powers of the position in SI, lowest first, of Legendre coefficients."""
        series = Legendre(coefficients, domain=[self.low, self.high])
        return tuple(
            float(c) for c in series.convert(kind=Polynomial, domain=[-1, 1], window=[-1, 1]).coef
        )

    def power_weights(self, rows: Matrix) -> Matrix:
        """What each power of the position, lowest first, is of the coefficients: (m, p); rows (m,
        p) picks Legendre's m of them."""
        convert = np.zeros((rows.shape[0], rows.shape[0]))
        for k, unit in enumerate(np.eye(rows.shape[0])):
            powers = self.powers(unit[: k + 1])
            convert[: len(powers), k] = powers
        return np.asarray(convert @ rows)


def fit_polynomials(
    places: BreakawayPositions, friction: Vector, structure: PolynomialOrders
) -> LeastSquaresSolution:
    """The coefficients of `structure`, in the order of `design`.

    Breakaways that follow each other are not independent: the place within its count in which the
    axis rests moves on by little.
    """
    together = FOLLOWING if friction.size >= FOLLOWING * FEWEST_GROUPS else 1
    return solve(
        places.design(structure),
        friction,
        np.ones(friction.size),
        np.arange(friction.size) // together,
    )


def sides_of(structure: PolynomialOrders, value: Vector) -> tuple[Vector, Vector]:
    """The coefficients forward and backward, without the offset; empty where a direction has
    none."""
    if structure.common:
        return value[:-1], value[:-1]
    split = structure.orders[0] + 1
    return value[:split], value[split:]


def choose_structure(places: BreakawayPositions, friction: Vector) -> PolynomialOrders:
    """What n frictions, (n,) N m | N, at `places` ask for."""
    forward = places.direction > 0.0
    present = (bool(np.any(forward)), bool(np.any(~forward)))
    own = [
        _order(places.scaled[side], friction[side]) if any_ else -1
        for side, any_ in zip((forward, ~forward), present, strict=True)
    ]
    separate = PolynomialOrders((own[0], own[1]), False)
    if not all(present):
        return separate
    errors = [
        left_out(places.design(PolynomialOrders((order, order), True)), friction)
        for order in range(_highest(friction.size) + 1)
    ]
    order = _smallest_as_good(errors)
    apart = left_out(places.design(separate), friction)
    return PolynomialOrders((order, order), True) if as_good(errors[order], apart) else separate


def _highest(count: int) -> int:
    return max(0, min(HIGHEST_ORDER, count // ROWS_PER_TERM - 1))


def _order(scaled: Vector, friction: Vector) -> int:
    return _smallest_as_good(
        [
            left_out(np.asarray(legvander(scaled, order), dtype=np.float64), friction)
            for order in range(_highest(friction.size) + 1)
        ]
    )


def _smallest_as_good(errors: list[Vector]) -> int:
    best = min(errors, key=lambda e: float(np.mean(e**2)))
    return next(order for order, error in enumerate(errors) if as_good(error, best))


def as_good(simple: Vector, best: Vector) -> bool:
    """Whether errors (n,) are as good as the best's."""
    more = simple**2 - best**2
    return bool(np.mean(more) <= SURE * np.std(more) / np.sqrt(more.size))


def left_out(rows: Matrix, friction: Vector) -> Vector:
    """The error (n,) at each breakaway of the fit to all others."""
    q, _ = np.linalg.qr(rows)
    residual = friction - q @ (q.T @ friction)
    return np.asarray(residual / np.maximum(1.0 - np.sum(q**2, axis=1), 1e-6))
