"""Instrumental variables computed from the reference of the position.

    0 = sum z (u - inertia a - viscous v - coulomb s - offset)

u is the measured effort, a the measured acceleration, v the measured velocity and s its sign. The
instruments z are the acceleration, velocity and sign of the velocity of the reference, and the
constant 1. The reference is smoothed by the same filter as the position. The instruments correlate
with the motion but not with the encoder's noise, so that the noise of a and v causes no bias.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.regression_samples import (
    RegressionSamples,
    cluster_products,
    fit,
    free_columns,
    intervals,
    joined,
    spread_as,
    with_fixed,
)
from frictool.identify.rows.slip_fit import full_backlash, slipping_rows, slipping_window
from frictool.identify.rows.slip_mask import keep_rows, slip_mask
from frictool.identify.rows.smoothing import smoothed
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

WEAKEST = 0.1  # least correlation of the velocity with the reference's velocity


def instrumental(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return inertia, viscous friction, Coulomb friction and offset by instrumental variables.

    Raises UnusableLogs if a record has no reference, or if the axis does not follow the reference.
    """
    for record in records:
        if record.reference is None:
            raise UnusableLogs(
                f"{record.name} has no reference of the position (channel reference), which the "
                "method instrumental needs; use least-squares"
            )
    window = slipping_window(records, settings.window)
    parts, instruments = [], []
    for record in records:
        signals = smoothed(record, window)
        instruments.append(_instruments(record, bench, window, signals[1]))
        parts.append(slipping_rows(record, bench, window, signals))
    samples = with_fixed(joined(parts), settings.fixed)
    plain = fit(
        samples, np.ones(samples.velocity.size), window, settings.confidence, {"window": window}
    )
    z = tuple(np.concatenate(columns) for columns in zip(*instruments, strict=True))
    if np.ptp(z[1]) == 0.0:
        raise UnusableLogs(
            "the reference stands still while the axis moves, as after a step; use least-squares"
        )
    correlation = float(np.corrcoef(z[1], samples.velocity)[0, 1])
    if correlation < WEAKEST:
        raise UnusableLogs(
            "the velocity does not follow the velocity of the reference (correlation "
            f"{correlation:.2g}); use least-squares"
        )
    result = by_instruments(samples, z, window, settings.confidence)
    details = {**plain.details, "reference_correlation": correlation}
    parameters = spread_as(
        plain.parameters, {name: result[name] for name in plain.parameters}, samples
    )
    return replace(plain, parameters=parameters, details=details)


def _instruments(
    record: MotionRecord, bench: Bench, window: int, velocity: Vector
) -> tuple[Vector, Vector, Vector]:
    assert record.reference is not None
    mask = slip_mask(record, find_strokes(record), velocity, window, full_backlash(bench))
    a, v, _ = smoothed(replace(record, position=record.reference), window)
    for values in (a, v):
        keep_rows(mask, values)
    kept = np.count_nonzero(mask)
    return a[:kept], v[:kept], np.sign(v[:kept])


def by_instruments(
    samples: RegressionSamples, z: tuple[Vector, ...], window: int, confidence: float
) -> dict[str, Interval]:
    """Estimate each parameter with its interval by instrumental variables.

    `z` contains the acceleration, the velocity and the direction of the reference, each (n,).
    """
    names, columns = free_columns(samples)
    p, every = len(names), (*z, np.ones(z[0].size))
    instruments = tuple(every[SLIDING.index(name)] for name in names)
    products, rows, cluster = cluster_products(
        samples, (*instruments, *columns, samples.effort), window
    )

    def estimate(total: Matrix, _rows: float) -> Vector:
        return np.asarray(np.linalg.solve(total[:p, p : 2 * p], total[:p, -1]))

    return intervals(products, rows, cluster, estimate, names, confidence)
