"""Prior distribution of friction over position, and orders that a log does not determine.

The effect `friction_over_position` of `effects.py` has the columns s P_k(x), with the direction s,
the position x and the Legendre polynomials P_k. Friction over position is modelled as a cubic
smoothing spline (Wahba 1978): the coefficients of the P_k are random and independent, with mean 0
and standard deviation t/k^2.

In a test with one sine, |speed| is an even function of the distance from the middle of the stroke.
The columns of the even orders then resemble the column of viscous friction, and the fitted interval
of an even order may be wider than its interval under the prior. Such an order is left out of the
fit; `further_orders.py` widens the intervals of the other parameters for the omitted order.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from frictool.identify.fit_result import Interval
from frictool.identify.rows.effects import EFFECTS
from frictool.typing import Vector

OVER_POSITION = next(one for one in EFFECTS if one.term == "friction_over_position")
FITTED_ORDERS = {name: k for k, name in enumerate(OVER_POSITION.names, start=1)}


def orders_above(order: int | None) -> frozenset[str]:
    """Return the names of the orders above `order`; the empty set if `order` is None."""
    return frozenset(name for name, k in FITTED_ORDERS.items() if order is not None and k > order)


def spline_scale(orders: Vector, coefficients: Vector) -> float:
    """Return the scale t [N m | N] of the prior (module docstring) from coefficients (n,)."""
    return float(np.sqrt(np.mean((orders**2 * coefficients) ** 2)))


def weak_orders(parameters: Mapping[str, Interval], confidence: float) -> tuple[str, ...]:
    """Return the fitted orders with wider intervals than under the prior (module docstring).

    The scale t of the prior follows from the squared coefficients. Each square is reduced by the
    variance of the coefficient, but not below 0. If all orders have such wide intervals, the result
    is empty, because the effect has to keep at least one column.
    """
    fitted = {name: parameters[name] for name in FITTED_ORDERS if name in parameters}
    if not fitted:
        return ()
    factor = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
    orders = np.array([FITTED_ORDERS[name] for name in fitted], dtype=np.float64)
    half = np.array([one.half_width for one in fitted.values()])
    squares = np.array([one.value**2 for one in fitted.values()]) - (half / factor) ** 2
    scale = spline_scale(orders, np.sqrt(np.maximum(squares, 0.0)))
    weak = half > factor * scale / orders**2
    return () if weak.all() else tuple(name for name, one in zip(fitted, weak, strict=True) if one)
