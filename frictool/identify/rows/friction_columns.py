"""Regressors of the weak form for friction that varies with position, and for speed knees.

    friction_k, load_k     sign(v) P_k(xi) and P_k(xi) with k = 1, 2, ..., for a polynomial of the
                           position in each direction
    bend_j                 sign(v) max(|v| - knee_j, 0), viscous friction added above a knee
                           (thesis, figure 4.10)
    knee_j                 derivative of the friction with respect to the knee's speed, so that
                           the intervals include the knee's uncertainty

A knee is a speed at which the viscous friction changes. xi is the position scaled to [-1, 1] over
the records, and P_k a Legendre polynomial, so that Coulomb friction and offset are means over the
range of positions. Each column is averaged with the test function of the weak form. The speed in
`bend_j` is the slope of a Savitzky-Golay cubic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.savitzky_golay import savitzky_golay
from frictool.identify.rows.smoothing import SHORTEST
from frictool.plant.weak_form import sampled_test_function
from frictool.typing import Vector

HIGHEST = 6  # highest order of the polynomials of the position, as for the breakaway
CUBIC = 3  # degree of the Savitzky-Golay polynomial
# length of the polynomial's window relative to the test function's window; with a longer window,
# the speed would be biased near the top speeds
SPEED_SHARE = 0.3


@dataclass(frozen=True)
class FrictionRows:
    """Regression rows (m,) of one record, and signals of its n samples.

    - sign: direction of the stroke, (n,)
    - speed: |v|, (n,), rad/s | m/s
    - kept: index of the sample in the middle of each row's window, (m,)
    - test_function: test function of the weak form at the samples of a window; the sum is 1
    """

    sign: Vector
    speed: Vector
    kept: NDArray[np.int64]
    test_function: Vector

    def windowed_mean(self, values: Vector) -> Vector:
        """Return the means (m,) of `values` (n,), weighted by the test function of each row."""
        return np.convolve(values, self.test_function, mode="same")[self.kept]


def rows_of(
    record: MotionRecord, sign: Vector, mask: NDArray[np.bool_], window: int
) -> FrictionRows:
    """Return the rows whose windows are centred at the samples in `mask` (n,).

    The axis must slip during each whole window of `window` samples. `sign` (n,) is the direction of
    motion.
    """
    shortened = max(SHORTEST, 2 * int(0.5 * SPEED_SHARE * window) + 1)
    slope = savitzky_golay(shortened, CUBIC, 1, record.period, last_first=True)
    velocity = np.convolve(record.position - record.position[0], slope, mode="same")
    return FrictionRows(sign, np.abs(velocity), np.flatnonzero(mask), sampled_test_function(window))


def position_columns(
    record: MotionRecord, rows: FrictionRows, low: float, high: float
) -> dict[str, Vector]:
    """Return the regressors (m,) for friction and load over position, by name.

    The names are friction_k and load_k for the degrees k = 1 to HIGHEST. `low` and `high` are the
    positions [rad | m] that are scaled to -1 and 1.
    """
    xi = 2.0 * (record.position - low) / (high - low) - 1.0
    powers = np.asarray(legvander(xi, HIGHEST), dtype=np.float64)
    out = dict[str, Vector]()
    for k in range(1, HIGHEST + 1):
        out[f"friction_{k}"] = rows.windowed_mean(rows.sign * powers[:, k])
        out[f"load_{k}"] = rows.windowed_mean(powers[:, k])
    return out


def names_to(order: int) -> list[str]:
    """Return the names friction_k and load_k of the polynomial columns for k = 1 to `order`."""
    return [f"{kind}_{k}" for k in range(1, order + 1) for kind in ("friction", "load")]


def bend_column(parts: Sequence[FrictionRows], knee: float) -> Vector:
    """Return the regressor (m,) of viscous friction added above the speed `knee` [rad/s | m/s]."""
    return np.concatenate(
        [rows.windowed_mean(rows.sign * np.maximum(rows.speed - knee, 0.0)) for rows in parts]
    )


def knee_column(parts: Sequence[FrictionRows], knee: float) -> Vector:
    """Return the derivative (m,) of `bend_column` with respect to the speed of the knee."""
    return np.concatenate([rows.windowed_mean(-rows.sign * (rows.speed > knee)) for rows in parts])
