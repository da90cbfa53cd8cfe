"""Detection of a logged effort that changes far less often than it is logged.

If the current was read too rarely, the logged current lags, on average, by half of the time between
two updates. This lag falsifies inertia and viscous friction. If the drive has a slow controller,
however, the effort really stays constant between two updates, and the log is valid. Let y be the
effort that the motion needs, y_held the value of y at the last update, v the velocity and a the
acceleration:

    logged effort = inertia a + viscous v + coulomb sign(v) + offset + declared loads
                    + b (y_held - y)

The coefficient b is 1 if the effort was read too rarely, and 0 if the logged effort really acted on
the axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, without_lag
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.effects import SmoothedMotion
from frictool.identify.rows.load_columns import load_columns
from frictool.identify.rows.regression_samples import RegressionSamples, parameters_of
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping, slipping_mask
from frictool.identify.rows.smoothing import smoothed
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Vector

FEWEST_UPDATES = 20
SHORTEST_HOLD = 3  # smallest number of samples between two updates that is examined
EARLY = 0.1  # quantile of the distances between updates that is used as the hold
# least median change at an update relative to the smallest changes (1 % quantile); an effort
# below this ratio is coarsely quantised, but not held
COARSE = 3.0
LEAST_EFFECT = 0.02  # relative change of the parameters below which there is no warning
MIXED = 1e-9  # largest weight of samples of another stroke in a smoothed sample
SLOW = 0.5  # coefficient b above which the effort was read too rarely
MOST_SAMPLES = 200_000  # largest number of samples of a record that are examined


@dataclass(frozen=True)
class HeldEffort:
    """Effort of a record that stays constant between updates, and its effect on the parameters.

    - hold: number of samples between two updates
    - low, high: confidence interval of the coefficient b, defined at the top of this module
    - logged: inertia fitted to the effort as it was logged, kg m^2 | kg
    - interpolated: inertia fitted to the effort interpolated between updates, kg m^2 | kg
    - effect: largest relative change of a parameter between these two fits. The change of the
      inertia is divided by the inertia. The change of another parameter is multiplied by the rms of
      its regressor and divided by the rms effort.
    """

    hold: int
    low: float
    high: float
    logged: float
    interpolated: float
    effect: float


def slow_effort_warnings(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> list[str]:
    """Return a warning for each record whose effort may have been read too rarely.

    Raises
    ------
    UnusableLogs
        If the effort of a record was certainly read too rarely.
    """
    warnings = []
    for record in records:
        effect = held_effort(without_lag(record, bench), bench, settings)
        if effect is None or effect.high < SLOW or effect.effect < LEAST_EFFECT:
            continue
        rates = (
            f"changes every {1e3 * effect.hold * record.period:.3g} ms, the position every "
            f"{1e3 * record.period:.3g} ms"
        )
        unit = si_unit("inertia", bench.axis)
        advice = "log the measured current as often as the position"
        if effect.low > SLOW:
            raise UnusableLogs(
                f"{Path(record.name).name}: the effort {rates}; a fit to this effort gives an "
                f"inertia of {effect.logged:.4g} instead of about {effect.interpolated:.4g} "
                f"{unit}; {advice}"
            )
        warnings.append(
            f"{Path(record.name).name}: the effort {rates}; the log does not show whether "
            f"the effort acted as logged (inertia {effect.logged:.4g} {unit}) or interpolated "
            f"({effect.interpolated:.4g} {unit}); {advice}"
        )
    return warnings


def hold_of(effort: Vector) -> tuple[int, NDArray[np.int64]] | None:
    """Return the number of samples between two updates of an effort (n,), and the updates (m,).

    An update is the index of a sample whose effort differs from the previous one. Return None if
    there are fewer than FEWEST_UPDATES updates, if the updates are fewer than SHORTEST_HOLD samples
    apart, or if the effort is only coarsely quantised (`COARSE`).
    """
    change = np.diff(effort)
    updates = np.flatnonzero(change) + 1
    if updates.size < FEWEST_UPDATES:
        return None
    hold = int(np.quantile(np.diff(updates), EARLY))
    sizes = np.abs(change[updates - 1])
    if hold < SHORTEST_HOLD or float(np.median(sizes)) < COARSE * float(np.quantile(sizes, 0.01)):
        return None
    return hold, updates


def held_effort(
    record: MotionRecord, bench: Bench, settings: IdentificationSettings
) -> HeldEffort | None:
    """Return how long a record's effort is constant, and how this changes the parameters.

    Return None if the effort is not constant between updates (`hold_of`), or if the record does not
    determine the effect.
    """
    record = record.part(slice(0, MOST_SAMPLES))
    hold = hold_of(record.effort)
    if hold is None:
        return None
    try:
        logged, window = slipping([record], bench, SMALLEST_SHARE, settings.window)
        parameters_of(logged)  # raises UnusableLogs if there are too few rows
        smooth = replace(record, effort=interpolated(record.effort, *hold))
        start = slipping([smooth], bench, SMALLEST_SHARE, settings.window)[0]
        cluster = clusters(logged.stroke, logged.sign, logged.counts, 3 * max(window, hold[0]))
        values = solve(_columns(start), start.effort, np.ones(start.sign.size), cluster).value
        needed = _needed(record, bench, window, values, logged.one_direction)
        last = np.maximum.accumulate(
            np.where(_updated(record.effort.size, *hold), np.arange(record.effort.size), 0)
        )
        number = find_strokes(record).number
        # 1 if the last update was in another stroke, or at rest
        before = (number[last] != number).astype(np.float64)
        late, mixed = (
            slipping([replace(record, effort=signal)], bench, SMALLEST_SHARE, settings.window)[
                0
            ].effort
            for signal in (needed[last] - needed, before)
        )
        kept = np.abs(mixed) < MIXED
        columns = _columns(logged)
        effort = logged.effort
        weight = np.ones(logged.effort.size)
        plain = solve(columns, effort, weight, cluster).value
        both = solve(
            np.column_stack((columns, late))[kept], effort[kept], weight[kept], cluster[kept]
        )
    except (UnusableLogs, SingularRegressors):
        return None
    share = float(both.value[-1])
    half = float(both.half_width(settings.confidence)[-1])
    change = np.abs(plain - values) * np.sqrt(np.mean(columns**2, axis=0) / np.mean(effort**2))
    effect = max(abs(float(plain[0] / values[0] - 1.0)), float(np.max(change[1:])))
    return HeldEffort(
        hold[0], share - half, share + half, float(plain[0]), float(values[0]), effect
    )


def interpolated(effort: Vector, hold: int, updates: NDArray[np.int64]) -> Vector:
    """Return the effort (n,), interpolated linearly between its updates."""
    at = np.flatnonzero(_updated(effort.size, hold, updates))
    return np.asarray(np.interp(np.arange(effort.size), at, effort[at]))


def _updated(size: int, hold: int, updates: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return a mask (size,) of the samples at which the logger read the effort.

    `updates` are the samples at which the value changes, and `hold` is the number of samples
    between two readings. A reading that repeats the last value causes no change. The sample `hold`
    samples before each change is therefore marked, too.
    """
    out = np.zeros(size, dtype=np.bool_)
    out[[0, *updates.tolist()]] = True
    before = updates - hold
    out[before[before > 0]] = True
    return out


def _columns(rows: RegressionSamples) -> Vector:
    constant = () if rows.one_direction else (np.ones(rows.sign.size),)
    return np.column_stack(
        (rows.acceleration, rows.velocity, rows.sign, *constant, *rows.loads.values())
    )


def _needed(
    record: MotionRecord, bench: Bench, window: int, values: Vector, one_direction: bool
) -> Vector:
    signals = smoothed(record, window)
    acceleration, velocity, _ = signals
    strokes = find_strokes(record)
    sign = strokes.sign
    constant = () if one_direction else (np.ones(sign.size),)
    used = slipping_mask(record, strokes, bench, velocity, window, 1)
    loads = load_columns(SmoothedMotion(record, window, *signals, sign, used, every=True), bench)
    columns = np.column_stack((acceleration, velocity, sign, *constant, *loads.values()))
    return np.asarray(np.where(np.isfinite(columns @ values), columns @ values, 0.0))
