"""Widening of intervals for orders of friction over position that the fit lacks.

A fit with the effect `friction_over_position` contains orders up to 3. It lacks the higher orders
of real friction, and the orders that the log does not determine (`rows/position_orders.py`). If the
strokes repeat each other, the speed is a function of the position. An omitted order then resembles
viscous friction, and is not visible in the residual.

The coefficients of the omitted orders are estimated together with the parameters. Their prior is
the prior of a cubic smoothing spline, with a scale t that is computed from the fitted coefficients:

    residual = X d + Z b + noise        b_k ~ N(0, t^2/k^4)

X contains the columns of the model. Z contains the columns s P_k of the omitted orders up to
HIGHEST_ORDER; s is the sign of the velocity, and P_k is the Legendre polynomial of order k. d is
the shift of the parameters.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.polynomial import legendre

from frictool.identify.effect_regression import AcceptedEffects, EffectRegression
from frictool.identify.estimators.searched_records import ROWS_PER_WINDOW
from frictool.identify.rows.load_terms import SPRING, TERMS
from frictool.identify.rows.position_orders import FITTED_ORDERS, OVER_POSITION, spline_scale
from frictool.typing import IntVector, Matrix, Vector

HIGHEST_ORDER = 6


def further_orders(regression: EffectRegression) -> AcceptedEffects | None:
    """Return the shift of the parameters due to omitted orders of friction over position.

    Return None if the model does not include friction over position.
    """
    rows = regression.rows
    used = regression.used
    indices = rows.columns(used)
    names = [rows.names[k] for k in indices]
    values = dict(zip(names, rows.fitted(indices).tolist(), strict=True))
    fitted = {k: values[name] for name, k in FITTED_ORDERS.items() if name in values}
    if not fitted:
        return None
    orders = np.array(list(fitted), dtype=np.float64)
    scale = spline_scale(orders, np.array(list(fitted.values())))
    omitted = np.array([k for k in range(1, HIGHEST_ORDER + 1) if k not in fitted])
    samples = rows.samples
    columns = _columns(samples.sign, samples.loads[TERMS[SPRING][0]], omitted)
    shift, deviation = _shift(rows.table(used), columns, rows.residual(used), scale / omitted**2)
    factor = float(scipy.special.stdtrit(orders.size, 0.5 + 0.5 * regression.confidence))
    places = {name: names.index(name) for name in regression.names}
    return AcceptedEffects(
        (OVER_POSITION.what,),
        1.0,
        {name: float(shift[k]) for name, k in places.items()},
        scatter={name: factor * float(deviation[k]) for name, k in places.items()},
    )


def _columns(sign: Vector, position: Vector, orders: IntVector) -> Matrix:
    """Return the columns (n, k) of k orders of friction over position.

    `position` (n,) is scaled to [-1, 1].
    """
    low, high = float(position.min()), float(position.max())
    scaled = 2.0 * (position - low) / (high - low) - 1.0
    return sign[:, None] * np.column_stack(
        [legendre.Legendre.basis(k)(scaled) for k in orders.tolist()]
    )


def _shift(
    columns: Matrix, further: Matrix, residual: Vector, prior: Vector
) -> tuple[Vector, Vector]:
    """Return the mean shift (p,), and the standard deviation (p,) that omitted orders add.

    - columns, further: regressors (n, p) of the model, and (n, k) of the omitted orders
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
