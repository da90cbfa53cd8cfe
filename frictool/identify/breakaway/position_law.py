"""Friction over position in each direction (thesis 4.44), as polynomials of selected orders.

    |friction| = sum_k c_k P_k(xi)

xi is the position scaled to [-1, 1], and P_k is a Legendre polynomial, so that c_0 is the mean over
the range of positions. The orders are compared by their leave-one-out errors at the same
breakaways. The lowest order whose error is within two standard errors of the smallest error is
chosen. The same rule decides between two models: one polynomial for each direction, and a common
polynomial with an offset of the effort. A load over position raises the effort in one direction and
lowers it in the other. If such a load is fitted too, both directions have a common polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from numpy.polynomial.legendre import legvander

from frictool.identify.regression.regression import LeastSquaresSolution, solve
from frictool.typing import Matrix, Vector

HIGHEST_ORDER = 6
# number of successive breakaways that are treated as one, and least number of such groups
FOLLOWING, FEWEST_GROUPS = 4, 12
SURE = 2.0  # standard errors within which two mean squares are treated as equal
ROWS_PER_TERM = 6  # number of breakaways needed for each coefficient
COUNTS_PER_TERM = 6  # least range of the breakaways' positions for each coefficient, encoder counts


@dataclass(frozen=True)
class PolynomialOrders:
    """Polynomial orders of the friction over position.

    - orders: order of the forward and of the backward polynomial; -1 for a direction without data
    - common: True if both directions have the same polynomial, of order orders[0], and the effort
      has an offset
    """

    orders: tuple[int, int]
    common: bool

    @property
    def constant(self) -> bool:
        """Return True if friction depends on neither position nor direction."""
        return max(self.orders) == 0 and (self.common or min(self.orders) < 0)


@dataclass(frozen=True)
class BreakawayPositions:
    """Position in [low, high], rad | m, and direction, +1 or -1, of each breakaway, (n,).

    - loads: efforts (n, q) of q loads over position, which are fitted together with the friction
    - highest: highest order of the polynomials
    """

    position: Vector
    direction: Vector
    low: float
    high: float
    loads: Matrix | None = None
    highest: int = HIGHEST_ORDER

    @property
    def scaled(self) -> Vector:
        """Return the position of each breakaway, scaled to [-1, 1], (n,)."""
        return (
            2.0 * (self.position - self.low) / (self.high - self.low) - 1.0
            if self.high > self.low
            else 0.0 * self.position
        )

    def design(self, structure: PolynomialOrders) -> Matrix:
        """Return the regressors (n, p) of the friction, first forward, then backward.

        For a common polynomial, the columns of its orders are followed by the direction, whose
        coefficient is the offset, and by the loads multiplied by the direction.
        """
        if structure.common:
            polynomial = legvander(self.scaled, structure.orders[0])
            loads = () if self.loads is None else (self.loads * self.direction[:, None]).T
            return np.column_stack((polynomial, self.direction, *loads))
        sides = []
        for side, order in zip((1.0, -1.0), structure.orders, strict=True):
            if order >= 0:
                sides.append(legvander(self.scaled, order) * (self.direction == side)[:, None])
        return np.column_stack(sides)

    def powers(self, coefficients: Vector) -> tuple[float, ...]:
        """Return the coefficients of position^i (SI, constant term first) of a Legendre series."""
        series = Legendre(coefficients, domain=[self.low, self.high])
        return tuple(
            float(c) for c in series.convert(kind=Polynomial, domain=[-1, 1], window=[-1, 1]).coef
        )

    def power_weights(self, rows: Matrix) -> Matrix:
        """Return the matrix (m, p) that turns fitted coefficients into coefficients of position^i.

        The p fitted coefficients are in the order of `design`. `rows` (m, p) selects the m Legendre
        coefficients of one polynomial. Row i of the result, times the fitted coefficients, is the
        coefficient of position^i of this polynomial in SI units.
        """
        convert = np.zeros((rows.shape[0], rows.shape[0]))
        for k, unit in enumerate(np.eye(rows.shape[0])):
            powers = self.powers(unit[: k + 1])
            convert[: len(powers), k] = powers
        return np.asarray(convert @ rows)


def fit_polynomials(
    positions: BreakawayPositions, friction: Vector, structure: PolynomialOrders
) -> LeastSquaresSolution:
    """Return the least-squares coefficients of friction over position, in the order of `design`.

    Successive breakaways are not independent, because the rest position within an encoder count
    changes slowly. Each group of FOLLOWING successive breakaways is therefore treated as one
    breakaway.
    """
    together = FOLLOWING if friction.size >= FOLLOWING * FEWEST_GROUPS else 1
    return solve(
        positions.design(structure),
        friction,
        np.ones(friction.size),
        np.arange(friction.size) // together,
    )


def sides_of(structure: PolynomialOrders, value: Vector) -> tuple[Vector, Vector]:
    """Split fitted coefficients into those of the forward and those of the backward polynomial.

    `value` contains all coefficients in the order of `design`. In each result, the lowest order is
    first; the result of a direction without data is empty.
    """
    split = structure.orders[0] + 1
    return value[:split], value[:split] if structure.common else value[split:]


def choose_structure(positions: BreakawayPositions, friction: Vector) -> PolynomialOrders:
    """Return the polynomial orders that the friction (n,) [N m | N] at the breakaways supports."""
    if positions.loads is not None:
        return _common_structure(positions, friction)[0]
    forward = positions.direction > 0.0
    present = (bool(np.any(forward)), bool(np.any(~forward)))
    orders = [
        _order(positions.scaled[side], friction[side], positions.highest) if any_ else -1
        for side, any_ in zip((forward, ~forward), present, strict=True)
    ]
    separate = PolynomialOrders((orders[0], orders[1]), False)
    if not all(present):
        return separate
    common, error = _common_structure(positions, friction)
    if positions.highest == 0:
        return common
    apart = left_out(positions.design(separate), friction)
    return common if as_good(error, apart) else separate


def _common_structure(
    positions: BreakawayPositions, friction: Vector
) -> tuple[PolynomialOrders, Vector]:
    """Return the lowest sufficient order of a common polynomial, and leave-one-out errors (n,)."""
    highest = _highest(friction.size, positions.highest)
    structures = [PolynomialOrders((order, order), True) for order in range(highest + 1)]
    errors = [left_out(positions.design(one), friction) for one in structures]
    order = _smallest_as_good(errors)
    return structures[order], errors[order]


def highest_order(counts: float) -> int:
    """Return the highest allowed order of a polynomial over `counts` encoder counts.

    Each coefficient needs COUNTS_PER_TERM counts, because the rest position within a count is
    unknown.
    """
    return max(0, min(HIGHEST_ORDER, int(counts / COUNTS_PER_TERM) - 1))


def _highest(count: int, highest: int) -> int:
    return max(0, min(highest, count // ROWS_PER_TERM - 1))


def _order(scaled: Vector, friction: Vector, highest: int) -> int:
    return _smallest_as_good(
        [
            left_out(np.asarray(legvander(scaled, order), dtype=np.float64), friction)
            for order in range(_highest(friction.size, highest) + 1)
        ]
    )


def _smallest_as_good(errors: list[Vector]) -> int:
    best = min(errors, key=lambda e: float(np.mean(e**2)))
    return next(order for order, error in enumerate(errors) if as_good(error, best))


def as_good(simple: Vector, best: Vector) -> bool:
    """Return True if the errors `simple` (n,) are not significantly above the errors `best`."""
    more = simple**2 - best**2
    return bool(np.mean(more) <= SURE * np.std(more) / np.sqrt(more.size))


def left_out(rows: Matrix, friction: Vector) -> Vector:
    """Return the leave-one-out errors (n,) of a least-squares fit with regressors `rows` (n, p)."""
    q, _ = np.linalg.qr(rows)
    residual = friction - q @ (q.T @ friction)
    return np.asarray(residual / np.maximum(1.0 - np.sum(q**2, axis=1), 1e-6))
