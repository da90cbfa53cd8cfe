"""Widening of intervals by friction over position of a higher order than the model includes.

The effect `friction_over_position` of `rows/effects.py` has the columns s P_k(x), k = 1 to 3, with
the direction s, the position x and the Legendre polynomials P_k. Real friction has higher orders,
too. If the strokes repeat each other, the speed is a function of the position. A higher order then
resembles viscous friction, and is not visible in the residual.

Friction over position is therefore modelled as a cubic smoothing spline (Wahba 1978): the
coefficients of the P_k are random and independent, with mean 0 and standard deviation t/k^2. The
coefficients of the fitted orders give t. The coefficients of the higher orders are estimated
together with the parameters, with this distribution as their prior:

    residual = X d + Z b + noise        b_k ~ N(0, t^2/k^4),   k in FURTHER_ORDERS

X contains the columns of the model, Z the columns of the higher orders, and d is the shift of the
parameters.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.polynomial import legendre

from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.estimators.explanation_search import ROWS_PER_WINDOW
from frictool.identify.rows.effects import EFFECTS
from frictool.identify.rows.load_terms import SPRING, TERMS
from frictool.typing import Matrix, Vector

OVER_POSITION = next(one for one in EFFECTS if one.term == "friction_over_position")
FURTHER_ORDERS = np.array([4, 5, 6])


def further_orders(regression: EffectRegression) -> AcceptedEffects | None:
    """Return the shift of the parameters due to higher orders of friction over position.

    Return None if the model does not include friction over position.
    """
    rows = regression.rows
    used = regression.used
    indices = rows.columns(used)
    names = [rows.names[k] for k in indices]
    if not set(OVER_POSITION.names) <= set(names):
        return None
    values = dict(zip(names, rows.fitted(indices).tolist(), strict=True))
    coefficients = np.array([values[name] for name in OVER_POSITION.names])
    orders = np.arange(1, coefficients.size + 1)
    spline = float(np.sqrt(np.mean((orders**2 * coefficients) ** 2)))
    samples = rows.samples
    columns = _columns(samples.sign, samples.loads[TERMS[SPRING][0]])
    shift, deviation = _shift(
        rows.table(used), columns, rows.residual(used), spline / FURTHER_ORDERS**2
    )
    factor = float(scipy.special.stdtrit(orders.size, 0.5 + 0.5 * regression.confidence))
    places = {name: names.index(name) for name in regression.names}
    return AcceptedEffects(
        (OVER_POSITION.what,),
        1.0,
        {name: float(shift[k]) for name, k in places.items()},
        scatter={name: factor * float(deviation[k]) for name, k in places.items()},
    )


def _columns(sign: Vector, position: Vector) -> Matrix:
    """Return the columns (n, k) of the higher orders; the positions (n,) are scaled to [-1, 1]."""
    low, high = float(position.min()), float(position.max())
    scaled = 2.0 * (position - low) / (high - low) - 1.0
    return sign[:, None] * np.column_stack(
        [legendre.Legendre.basis(k)(scaled) for k in FURTHER_ORDERS]
    )


def _shift(
    columns: Matrix, further: Matrix, residual: Vector, prior: Vector
) -> tuple[Vector, Vector]:
    """Return the mean shift (p,), and the standard deviation (p,) that higher orders add.

    - columns, further: regressors (n, p) of the model, and (n, k) of the higher orders
    - residual: residual (n,) of the fit to `columns`
    - prior: standard deviations (k,) of the coefficients of `further`

    The rows within a smoothing window are dependent, and count as one row.
    """
    count = prior.size
    p = columns.shape[1]
    noise = float(np.sqrt(ROWS_PER_WINDOW * np.mean(residual**2)))
    known = np.hstack((np.zeros((count, p)), np.diag(noise / prior)))
    whole = np.vstack((np.hstack((columns, further)), known))
    scale = np.linalg.norm(whole, axis=0)
    inverse = np.linalg.pinv(whole / scale) / scale[:, None]
    alone = np.linalg.pinv(columns / scale[:p]) / scale[:p, None]
    shift = inverse[:p, : residual.size] @ residual
    added = noise**2 * (np.sum(inverse[:p] ** 2, axis=1) - np.sum(alone**2, axis=1))
    return np.asarray(shift), np.sqrt(np.maximum(added, 0.0))
