"""Power balance, with the equation of motion multiplied by sqrt(2)/V; V is the speed amplitude.

M_2 is the 2 x 2 submatrix of the normal matrix for viscous and Coulomb friction. If the velocity is
a sine of amplitude sqrt(2) in SI units, the condition number of M_2 is 19, the least possible for a
sine (thesis 4.29 to 4.33). The estimates equal those of `power_balance`, because every fit of
frictool scales its columns to unit length. The fit also reports the condition numbers of M_2 before
and after the multiplication.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.estimators.power_balance import by_speed
from frictool.identify.fit_result import SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.regression_samples import RegressionSamples, fit
from frictool.identify.rows.slip_fit import slipping_fit
from frictool.typing import Vector

BEST_SPEED = math.sqrt(2.0)  # speed amplitude with the least condition number of M_2 (4.30)


def condition_m2(velocity: Vector, sign: Vector) -> float:
    """Return the condition number of M_2, the normal matrix of viscous and Coulomb friction.

    `velocity` [rad/s | m/s] and `sign` (+1 or -1), each (n,), are the velocity and the direction of
    motion of each row.
    """
    singular = np.linalg.svd(
        np.linalg.qr(np.column_stack((velocity, sign)), mode="r"), compute_uv=False
    )
    return float((singular[0] / singular[-1]) ** 2)


def conditioned(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by the scaled power balance.

    Raises UnusableLogs if the records have too few samples of sliding motion.
    """
    return slipping_fit(
        records, bench, settings, lambda rows, used: _fit(rows, used, settings.confidence)
    )


def _fit(samples: RegressionSamples, window: int, confidence: float) -> SlidingFit:
    scale = BEST_SPEED / float(np.max(np.abs(samples.velocity)))
    result = fit(samples, scale * by_speed(samples), window, confidence, {"window": window})
    before = condition_m2(samples.velocity, samples.sign)
    after = condition_m2(scale * samples.velocity, samples.sign)
    return replace(
        result, details={**result.details, "condition_m2": before, "condition_m2_scaled": after}
    )
