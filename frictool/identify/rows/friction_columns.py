"""Regressors of a friction that is no constant and a slope: over the position, and with bends over
the speed; for the weak form.

    friction_k, load_k     sign(v) P_k(xi) and P_k(xi), k = 1, 2, ...: a polynomial of the position
                           for each direction (4.44)
    bend_j                 sign(v) (|v| - knee_j)+: what is added to the viscous friction above a
                           knee (figure 4.10)
    knee_j                 the derivative by the knee, so that the intervals hold what is uncertain
                           of its place

xi is the position in [-1, 1] over the records, P_k Legendre's, so that Coulomb friction and offset
stay their means over the range. Along a stroke of a sine the acceleration goes with the position: a
friction that does too has to have its own columns, or the inertia is wrong. Each column is under
the bell of the acceleration. The speed that bends is a cubic's of Savitzky and Golay: a bell would
take off the top of a stroke, and differences between counts would round the knee.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs

from frictool.identify.motion_record import MotionRecord, Vector
from frictool.identify.rows.smoothing import SHORTEST
from frictool.plant.weak_form import bell

HIGHEST = 6  # order of the polynomials, as of the breakaway's
CUBIC, SPEED_SHARE = (
    3,
    0.3,
)  # of the window: longer, the cubic is off at the top of the fastest strokes


@dataclass(frozen=True)
class FrictionRows:
    """What the rows of one record, (m,) of its n samples, have been taken from: `sign` and `speed`
    |v| (n,), and which they are."""

    sign: Vector
    speed: Vector
    kept: NDArray[np.int64]
    bell: Vector

    def under_bell(self, values: Vector) -> Vector:
        """The means (m,) of values (n,)."""
        return np.convolve(values, self.bell, mode="same")[self.kept]


def rows_of(
    record: MotionRecord, sign: Vector, mask: NDArray[np.bool_], window: int
) -> FrictionRows:
    """Of the samples of `mask` (n,), certain to slip over `window`; `sign` (n,) of the strokes."""
    slope = savgol_coeffs(
        max(SHORTEST, 2 * int(0.5 * SPEED_SHARE * window) + 1), CUBIC, deriv=1, delta=record.period
    )
    velocity = np.convolve(record.position - record.position[0], slope, mode="same")
    return FrictionRows(sign, np.abs(velocity), np.flatnonzero(mask), bell(window))


def position_columns(
    record: MotionRecord, rows: FrictionRows, low: float, high: float
) -> dict[str, Vector]:
    """Of each polynomial over [low, high], rad | m, up to HIGHEST the columns (m,)."""
    xi = 2.0 * (record.position - low) / (high - low) - 1.0
    powers, out = np.asarray(legvander(xi, HIGHEST), dtype=np.float64), dict[str, Vector]()
    for k in range(1, HIGHEST + 1):
        out[f"friction_{k}"], out[f"load_{k}"] = (
            rows.under_bell(rows.sign * powers[:, k]),
            rows.under_bell(powers[:, k]),
        )
    return out


def names_to(order: int) -> list[str]:
    """The columns of polynomials up to an order."""
    return [f"{kind}_{k}" for k in range(1, order + 1) for kind in ("friction", "load")]


def bend_column(parts: Sequence[FrictionRows], knee: float) -> Vector:
    """What a unit viscous friction above the knee, rad/s | m/s, adds to each row of all records."""
    return np.concatenate(
        [rows.under_bell(rows.sign * np.maximum(rows.speed - knee, 0.0)) for rows in parts]
    )


def knee_column(parts: Sequence[FrictionRows], knee: float) -> Vector:
    """The same by the knee: minus the share of each row that is faster, signed."""
    return np.concatenate([rows.under_bell(-rows.sign * (rows.speed > knee)) for rows in parts])
