"""Common reference temperature of records, and shape of friction over temperature.

    effort = inertia a + viscous exp(r h + k h^2) v + coulomb exp(q h) s + offset

a is the acceleration, v the velocity, s the sign of v, and h the temperature minus the reference.
The viscosity of a lubricant falls by nearly the same ratio per kelvin at all temperatures
(Reynolds, 1886). Bittencourt and Axelsson (2014) identify an exponential for the viscous friction
of a robot joint. k is 0 unless the logs show a curvature. Gauss-Newton steps determine r, k and q,
from which the columns of the effect `temperature` follow. The coefficients of these columns are
fitted together with the other parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord, reference_temperature
from frictool.identify.rows.effects import TEMPERATURE
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from frictool.identify.rows.temperature_law import temperatures, varies
from frictool.typing import Matrix, Vector

STEPS = 8  # Gauss-Newton steps
MOST = np.array([0.1, 0.1, 0.002])  # 1/K, 1/K, 1/K^2: largest r, q and k
MOST_ROWS = 100_000  # largest number of rows; more are thinned evenly
# least increase of twice the log likelihood with which a curvature is used: two standard deviations
LEAST_GAIN = 4.0
# least rms deviation of h^2 from its regression on h, relative to the squared range of h; 0.075 for
# a uniform distribution, 0 for two temperatures
LEAST_CURVATURE = 0.02


def shaped(records: Sequence[MotionRecord], bench: Bench) -> list[MotionRecord]:
    """Return the records with a common reference temperature and with exponents of friction.

    The exponents describe friction over temperature, and are set only if the temperature varies
    enough. If a record has no temperature, all records are returned unchanged.
    """
    measured = [one.temperature for one in records if one.temperature is not None]
    if not measured or len(measured) < len(records):
        return list(records)
    reference = reference_temperature([one.values for one in measured])
    referred = [
        replace(one, temperature=replace(warm, reference=reference))
        for one, warm in zip(records, measured, strict=True)
    ]
    if not varies(temperatures(referred)):
        return referred
    viscous, coulomb, curvature = _shape(referred, bench)
    return [
        replace(
            one,
            temperature=replace(
                warm,
                reference=reference,
                viscous_rate=viscous,
                coulomb_rate=coulomb,
                viscous_curvature=curvature,
            ),
        )
        for one, warm in zip(records, measured, strict=True)
    ]


def _shape(records: list[MotionRecord], bench: Bench) -> tuple[float, float, float]:
    """Return the exponents r [1/K], q [1/K] and k [1/K^2] defined in the module docstring.

    r and k belong to viscous friction, q to Coulomb friction. All exponents are 0 if the axis never
    slips.
    """
    alone = msgspec.structs.replace(bench, load=LoadTerms(("offset", TEMPERATURE)))
    try:
        samples, window = slipping(records, alone, SMALLEST_SHARE, None)
    except UnusableLogs:
        return 0.0, 0.0, 0.0
    # if all exponents are 0, the second column of the effect is s h
    excess = samples.sign * samples.loads["coulomb_temperature"]
    every = max(1, excess.size // MOST_ROWS)
    signals = (*samples.columns, excess, samples.effort)
    rows = np.column_stack([one[::every] for one in signals])
    line, left = _fitted(rows, curved=False)
    square, less = _fitted(rows, curved=True)
    gain = excess.size / window * np.log(left / less)
    if _can_show_curvature(rows[:, 4]) and gain > LEAST_GAIN:
        line = square
    return float(line[0]), float(line[1]), float(line[2])


def _fitted(rows: Matrix, curved: bool) -> tuple[Vector, float]:
    """Return the exponents r, q, k (3,) (module docstring), and the sum of squared residuals.

    The columns of `rows` (n, 6) are acceleration, velocity, direction, 1, temperature above the
    reference, and effort. If `curved` is False, k is 0.
    """
    a, v, s, one, h, effort = rows.T
    shape = np.zeros(3)
    left = np.inf
    for _ in range(STEPS):
        viscous = v * np.exp(shape[0] * h + shape[2] * h**2)
        coulomb = s * np.exp(shape[1] * h)
        slopes = [h * viscous, h * coulomb, *([h**2 * viscous] if curved else [])]
        columns = np.column_stack([a, one, viscous, coulomb, *slopes])
        scale = np.linalg.norm(columns, axis=0)
        value = np.linalg.lstsq(columns / scale, effort, rcond=None)[0] / scale
        left = float(np.sum((effort - columns @ value) ** 2))
        if not (value[2] > 0.0 and value[3] > 0.0):
            break
        step = np.zeros(3)
        step[: len(slopes)] = value[4:] / value[[2, 3, 2][: len(slopes)]]
        shape = np.clip(shape + step, -MOST, MOST)
    return shape, left


def _can_show_curvature(excess: Vector) -> bool:
    """Return whether the temperatures `h` (n,) can show a curvature; two levels are not enough."""
    scaled = excess / np.ptp(excess)
    line = np.column_stack([np.ones(scaled.size), scaled])
    left = scaled**2 - line @ np.linalg.lstsq(line, scaled**2, rcond=None)[0]
    return bool(np.sqrt(np.mean(left**2)) > LEAST_CURVATURE)
